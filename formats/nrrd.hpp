#pragma once

#include <cstdint>
#include <filesystem>

#include "core/volume.hpp"

namespace angio::formats {

enum class NrrdEncoding { raw, gzip };

/// Writes a volume as attached NRRD (.nrrd, NRRD0005, LPS, little-endian), atomically and without
/// time stamps, so that the same volume gives the same bytes.
///
/// @throws IoError if the file cannot be written
void write_nrrd(const std::filesystem::path& path, const Volume<float>& volume,
                NrrdEncoding encoding = NrrdEncoding::gzip);
void write_nrrd(const std::filesystem::path& path, const Volume<std::uint8_t>& volume,
                NrrdEncoding encoding = NrrdEncoding::gzip);

/// A scalar volume from an attached NRRD file (.nrrd), as write_nrrd writes it: three dimensions,
/// encoding raw or gzip, any number type, space LPS or RAS (converted). It is for files of ours; a
/// volume that a user gives is read by the segmentation stage, which trusts no file.
///
/// @throws InputError naming the file if it is missing (66), damaged or of another kind (65)
Volume<float> read_nrrd(const std::filesystem::path& path);

}  // namespace angio::formats

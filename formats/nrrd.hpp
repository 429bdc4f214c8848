#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

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

/// A segment as 3D Slicer names and colours it.
struct SegmentLabel {
  std::string name;                          ///< without a line break
  std::array<double, 3> rgb{1.0, 1.0, 1.0};  ///< [0, 1]
};

/// Writes a mask as 3D Slicer's segmentation (.seg.nrrd): a NRRD of uint8 whose header also holds
/// Slicer's fields Segment0_... (identity, name, colour, label value 1, extent) and
/// Segmentation_...
///
/// @param mask  1 in the segment, 0 outside
void write_segmentation(const std::filesystem::path& path, const Volume<std::uint8_t>& mask,
                        const SegmentLabel& label);

/// A scalar volume from an attached NRRD file (.nrrd), as write_nrrd writes it: three dimensions,
/// encoding raw or gzip, any number type, space LPS or RAS (converted). It is for files of ours; a
/// volume that a user gives is read by the segmentation stage, which trusts no file.
///
/// @throws InputError naming the file if it is missing (66), damaged or of another kind (65)
Volume<float> read_nrrd(const std::filesystem::path& path);

}  // namespace angio::formats

#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/volume.hpp"
#include "datasets/rotational_run.hpp"

namespace angio::datasets::detail {

/// A UID under 2.25 (ISO/IEC 9834-8: a UUID as one decimal number) that depends on `text` alone.
std::string uid_from(std::string_view text);

/// Writes a volume as a series of CT Image Storage objects, IM0001.dcm ... along k: 16 bit signed,
/// rounded to whole Hounsfield units, explicit VR little endian. Equal arguments give equal bytes.
///
/// @param name         patient's name is PHANTOM^NAME
/// @param fingerprint  what the UIDs are made from
/// @param folder       exists; files in it of these names are replaced
/// @throws IoError
void write_dicom_series(const Volume<float>& volume, std::string_view name,
                        std::string_view fingerprint, const std::filesystem::path& folder);

/// The same volume as one X-Ray 3D Angiographic Image Storage object, IM0001.dcm: unsigned 16 bit,
/// geometry in functional groups. Values below -1024 become -1024.
void write_dicom_xray_3d(const Volume<float>& volume, std::string_view name,
                         std::string_view fingerprint, const std::filesystem::path& folder);

/// A run as one multi-frame X-Ray Angiographic Image Storage object: unsigned 16 bit, linear in the
/// beam's intensity.
///
/// @param pixels  shape [frames, rows, columns]
/// @param first_frame  of the run that is written: of a standing C-arm its view's first
/// @param number  of the acquisition, from 1; the masks come before the contrast medium
/// @param has_contrast_medium  is a contrast medium named in it?
void write_xa_run(const RotationalRunOfPhantom& run, const std::vector<std::uint16_t>& pixels,
                  std::string_view name, std::string_view fingerprint, int number,
                  bool has_contrast_medium, const std::filesystem::path& path,
                  std::size_t first_frame = 0);

}  // namespace angio::datasets::detail

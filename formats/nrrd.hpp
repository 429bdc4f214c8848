#pragma once

#include <filesystem>

#include "core/volume.hpp"

namespace angio::formats {

/// A scalar volume from an attached NRRD file (.nrrd), as the segmentation stage writes it: three
/// dimensions, encoding raw or gzip, any number type, space LPS or RAS (converted).
///
/// @throws InputError naming the file if it is missing (66), damaged or of another kind (65)
Volume<float> read_nrrd(const std::filesystem::path& path);

}  // namespace angio::formats

#pragma once

#include <filesystem>

#include "core/volume.hpp"

/// Volumes for other programs, written atomically and without time stamps; float, little-endian,
/// millimetres. Readers of both formats are the segmentation stage's.
namespace angio::formats {

/// MetaImage with its voxels in it (.mha), compressed; axes and origin in LPS, as ITK has them.
/// @throws IoError if the file cannot be written
void write_mha(const std::filesystem::path& path, const Volume<float>& volume);

/// NIfTI-1 in one gzip stream (.nii.gz); axes and origin in RAS, as sform and, of what is left of
/// them without shear, as qform (code 1, scanner).
/// @throws InputError if an axis has more than 32767 voxels, which NIfTI-1 cannot say
void write_nifti(const std::filesystem::path& path, const Volume<float>& volume);

}  // namespace angio::formats

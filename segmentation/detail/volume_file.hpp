#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// Whether a name ends like a volume file: .nrrd .nhdr .mha .mhd .nii .nii.gz .vti.
bool is_volume_file_name(const std::filesystem::path& path);

/// The format in words, e.g. "NRRD".
std::string volume_file_format(const std::filesystem::path& path);

struct VolumeFile {
  Volume<float> volume;               ///< LPS, right-handed; no values if only the header was asked
  std::vector<std::string> warnings;  ///< e.g. an axis that was turned to make it right-handed
};

enum class VolumePart { whole, header };

/// Reads a volume file other than DICOM.
/// @throws InputError if it is damaged, has no spacing, is not three-dimensional, or is sheared
VolumeFile load_volume_file(const std::filesystem::path& path, VolumePart part);

/// ITK's part of load_volume_file: NRRD, MetaImage, NIfTI.
VolumeFile load_with_itk(const std::filesystem::path& path, VolumePart part);
/// VTK's part: .vti.
VolumeFile load_vti(const std::filesystem::path& path, VolumePart part);

/// Makes the axes orthonormal and right-handed, reversing the order of slices if it must.
/// @throws InputError if the axes are not at right angles, or a size or spacing is impossible
void make_right_handed(VolumeFile& file, const std::string& name);

}  // namespace angio::segmentation::detail

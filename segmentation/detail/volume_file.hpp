#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::segmentation::detail {

/// Whether a name ends like a volume file: .nrrd .nhdr .mha .mhd .nii .nii.gz .vti .vtk .tif .tiff.
bool is_volume_file_name(const std::filesystem::path& path);

/// The format in words, e.g. "NRRD".
std::string volume_file_format(const std::filesystem::path& path);

struct VolumeFile {
  Volume<float> volume;               ///< LPS, right-handed; no values if only the header was asked
  std::vector<std::string> warnings;  ///< e.g. an axis that was turned to make it right-handed
  double unit_mm = 1.0;               ///< that the file states and the grid was scaled by [mm]
};

enum class VolumePart { whole, header };

/// Reads a volume file other than DICOM, in a child process: ITK and VTK trust what they read.
/// @throws InputError if it is damaged, has no spacing, is not three-dimensional, or is sheared
VolumeFile load_volume_file(const std::filesystem::path& path, VolumePart part,
                            const ReadOptions& options);

/// ITK's part of load_volume_file: NRRD, MetaImage.
VolumeFile load_with_itk(const std::filesystem::path& path, VolumePart part,
                         const ReadOptions& options);
/// NIfTI-1 and -2, read here: ITK refuses axes that are off by rounding. The
/// grid is that of the sform, else of the qform, else of the voxel sizes alone.
VolumeFile load_nifti(const std::filesystem::path& path, VolumePart part);
/// VTK's part: .vti, and .vtk of its legacy format.
VolumeFile load_vti(const std::filesystem::path& path, VolumePart part);

/// Makes the axes orthonormal and right-handed, reversing the order of slices if it must. Axes off
/// the right angle by up to 0.001 are set right, which moves no voxel by more than half its size.
/// @throws InputError if the axes are not at right angles, or a size or spacing is impossible
void make_right_handed(VolumeFile& file, const std::string& name);

}  // namespace angio::segmentation::detail

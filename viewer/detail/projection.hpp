#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/volume.hpp"

namespace angio::viewer::detail {

/// A maximum intensity projection along the volume axis that is nearest to one of the patient's,
/// laid out as a radiologist expects it.
struct Projection {
  std::string name;           ///< "axial", "coronal" or "sagittal"
  int width = 0;              ///< [pixel], one voxel each
  int height = 0;             ///< [pixel]
  double pixel_width_mm = 1;  ///< pixels need not be square
  double pixel_height_mm = 1;
  std::vector<float> values;  ///< rows from the top, shape [height, width]

  // How a pixel is found: the volume's axes across and down, and whether they run backwards.
  int axis_right = 0;
  int axis_down = 1;
  bool right_reversed = false;
  bool down_reversed = false;
  std::array<int, 3> first{};  ///< first voxel of the box that is shown

  struct Pixel {
    double x = 0.0;
    double y = 0.0;
  };
  /// Where a point falls. @param index  continuous voxel index of the volume
  [[nodiscard]] Pixel pixel_of(const Vec3& index) const;
};

/// A box of voxels, [first, last] inclusive.
struct VoxelBox {
  std::array<int, 3> first{};
  std::array<int, 3> last{};
};

/// The voxels around some points, with a margin, within the volume; at least one voxel.
VoxelBox box_around(const VolumeGeometry& grid, const std::vector<Vec3>& points_in_lps,
                    double margin_mm);

/// Axial (left of the patient at the right, back below), coronal (left at the right, feet below)
/// and sagittal (back at the right, feet below), through the box only, so that bone and other
/// organs do not hide the vessels.
std::vector<Projection> project_maximum(const Volume<float>& volume, const VoxelBox& box);

}  // namespace angio::viewer::detail

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// Convolves with a Gaussian; the border voxel is repeated beyond the border.
///
/// @param sigma_mm  standard deviation along each of the grid's axes; an axis with spacing above 5
///                  sigma is left as it is
Volume<float> smooth(const Volume<float>& volume, const Vec3& sigma_mm);
/// The same with one standard deviation along all axes.
Volume<float> smooth(const Volume<float>& volume, double sigma_mm);

/// The geometric mean of a voxel's edges [mm].
double mean_spacing(const VolumeGeometry& geometry);

/// [mm^3]
double voxel_volume(const VolumeGeometry& geometry);

/// Where a voxel's centre lies, LPS [mm].
Vec3 place_of_voxel(const VolumeGeometry& geometry, std::size_t offset);

/// Averages blocks of voxels; incomplete blocks at the far border are averaged as they are.
Volume<float> block_average(const Volume<float>& volume, const std::array<int, 3>& factor);

/// The block size that brings every spacing near `spacing_mm`, at least 1.
std::array<int, 3> block_size(const VolumeGeometry& geometry, double spacing_mm);

/// A box of voxels, [first, first + size).
struct VoxelBox {
  std::array<int, 3> first{0, 0, 0};
  std::array<int, 3> size{0, 0, 0};
};

/// The part of a grid inside a box; the box must lie inside.
VolumeGeometry cropped_geometry(const VolumeGeometry& geometry, const VoxelBox& box);

template <class Value>
Volume<Value> crop(const Volume<Value>& volume, const VoxelBox& box) {
  Volume<Value> part(cropped_geometry(volume.geometry, box));
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j) {
      const auto* row = &volume.at(box.first[0], box.first[1] + j, box.first[2] + k);
      std::copy(row, row + box.size[0], &part.at(0, j, k));
    }
  return part;
}

/// A field on a block-averaged grid, read at the voxels of the fine grid by trilinear
/// interpolation.
class CoarseField {
 public:
  CoarseField(Volume<float> coarse, const std::array<int, 3>& factor);
  /// Reads a row of fine voxels (., j, k) into out, shape [count].
  void row(int j, int k, int count, float* out) const { row(0, j, k, count, out); }
  /// The same from voxel (first, j, k) on.
  void row(int first, int j, int k, int count, float* out) const;
  [[nodiscard]] const Volume<float>& coarse() const { return coarse_; }
  [[nodiscard]] const std::array<int, 3>& factor() const { return factor_; }

 private:
  Volume<float> coarse_;
  std::array<int, 3> factor_;
};

}  // namespace angio::segmentation::detail

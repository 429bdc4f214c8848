#pragma once

#include <array>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/patch.hpp"

namespace angio::segmentation::detail {

/// What the blur is fitted within. With less than 0.3 voxels, over 40 % of the contrast would be
/// left at the grid's highest frequency, besides the voxel's own box: no image that was sampled
/// without aliasing has that, and an edge that seems as sharp was clipped or sharpened.
constexpr double kLeastBlurVoxels = 0.3, kMostBlurVoxels = 3.0;

/// The scanner's blur: a Gaussian whose standard deviation is told for each axis of the voxels.
struct Blur {
  Vec3 sd_voxels{0.6, 0.6, 0.6};
  bool is_told = false;  ///< false: too few edges, or none that fits; the values are assumed
};

/// The finer grid on which the boundary is kept: `ratio` steps for each voxel, along each axis, so
/// that every voxel's centre is one of its points.
struct FineGrid {
  std::array<int, 3> ratio{1, 1, 1};
  [[nodiscard]] VolumeGeometry geometry(const VolumeGeometry& voxels) const;
};

/// A distance on the fine grid, by Catmull-Rom cubics where it is near zero.
///
/// @param far_mm  farther than this the result holds this value, with the distance's sign; well
/// over
///                a voxel, or cubics could turn signs there
Volume<float> refine_near_zero(const Volume<float>& distance, const FineGrid& fine, float far_mm);

/// Weights at 0, 1, ... voxels of a Gaussian sampled there, as narrow as gives the weights the
/// variance asked for: far below a voxel, samples of that variance itself would have next to none.
std::vector<float> sampled_gaussian(double variance);

/// Convolves along one axis; the patch shrinks to the values whose neighbours it holds.
void convolve(Patch& patch, const std::vector<float>& kernel, int axis,
              std::vector<float>& scratch);

/// P: the part of each voxel inside, from the distances at the voxels' centres.
void part_inside(Patch& part, const Patch& distance, const Vec3& spacing);

/// The blur's weights along each axis.
using BlurKernels = std::array<std::vector<float>, 3>;
BlurKernels blur_kernels(const Blur& blur);
int longest_reach(const BlurKernels& kernels);

/// Whether voxels of a brick lie within a band beside the boundary.
bool is_at_boundary(const Volume<float>& phi, const FineGrid& fine, const Brick& brick,
                    float band_mm);

/// The bricks that do.
std::vector<Brick> bricks_at_boundary(const Volume<float>& phi, const FineGrid& fine,
                                      const VolumeGeometry& voxels, float band_voxels);

/// The part of each voxel inside the boundary, blurred: S.
Volume<float> blurred_share(const Volume<float>& phi, const FineGrid& fine,
                            const VolumeGeometry& voxels, const Blur& blur);

}  // namespace angio::segmentation::detail

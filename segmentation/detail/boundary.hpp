#pragma once

#include <cstdint>
#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {

/// The lumen's sub-voxel boundary.
struct Boundary {
  Volume<float> level_set;  ///< signed distance [mm], negative inside
  double lumen_intensity = 0.0;
  double background_intensity = 0.0;
  double blur_mm = 0.0;  ///< standard deviation of the blur across the boundary, measured
  std::vector<Vec3> bridges_lps_mm;  ///< places too narrow for the voxels, kept open
};

/// Finds where a vessel's voxels are half lumen, half background, by local intensities:
///
///     F = (I - T) / (L - B),    T = B + (L - B) / 2
///
/// L is the mean of voxels deep inside the vessel, B that of voxels around it, both spread by
/// normalised convolution from wide kernels to narrow ones, so that a narrow place, whose own peak
/// is blurred, takes L from the vessel beside it. The steps are repeated from the boundary found.
/// T stays below the local peak, so that no vessel is lost that the tree holds.
///
/// @param volume  denoised intensities around the tree
/// @param tree    its voxels, on the same grid
Boundary find_boundary(const Volume<float>& volume, const Volume<std::uint8_t>& tree,
                       const SegmentationOptions& options, const Progress& progress);

}  // namespace angio::segmentation::detail

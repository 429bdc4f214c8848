#pragma once

#include "core/centerline.hpp"
#include "core/volume.hpp"

namespace angio::reconstruction::detail {

/// A tree as a scan would show it: `value` in tubes of round section around its lines, cut flat at
/// their ends, 0 outside, voxels on the wall by the part within:
///
///     v(x) = value clamp(1/2 - d(x) / h, 0, 1),   d(x) = min over lines, t of |x - c(t)| - r(t)
///
/// @param tree      points and `equivalent_radius` of each path
/// @param voxel_mm  h, > 0
/// @param largest_side  voxels along an edge; the voxels grow until they are no more
Volume<float> tube_volume(const CenterlineTree& tree, double value, double voxel_mm,
                          int largest_side);

/// The grid that this volume would have.
VolumeGeometry tube_grid(const CenterlineTree& tree, double voxel_mm, int largest_side);

}  // namespace angio::reconstruction::detail

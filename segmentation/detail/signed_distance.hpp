#pragma once

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// To which the lumen's level set tells distances outside [mm].
inline constexpr double kReachMm = 5.0;

/// Signed Euclidean distance [mm] to the zero of a level function, negative where it is negative.
///
/// Beside the zero, the distance is that to the plane through the crossings d_x, d_y, d_z that
/// linear interpolation finds on the voxel's grid lines, then its foot is moved onto the zero of
/// the cubic interpolant (linear interpolation would shrink a bent surface by h^2 / 12 (k1 + k2)):
///
///     n = (s_x / d_x, s_y / d_y, s_z / d_z),    1 / d^2 = |n|^2,    foot = x + n / |n|^2
///
/// Further out every voxel takes over the best of its neighbours' closest points, near ones first,
/// so that distances are to the interpolated surface and not to voxels. Beyond four voxels this is
/// done on every other voxel, and those between take the surface's tangent plane at the nearest of
/// the points around them.
/// Source: Danielsson, "Euclidean distance mapping", CGIP 14, 1980,
///         doi:10.1016/0146-664X(80)90054-4, for the handing on; the first layer is that of
///         Adalsteinsson & Sethian, J. Comput. Phys. 148, 1999, doi:10.1006/jcph.1998.6090.
///
/// @param level     any continuous function, negative inside
/// @param reach_mm  outside, distances end at this value; inside there is no end
/// @return -infinity everywhere if the level is negative everywhere
Volume<float> signed_distance(Volume<float> level, double reach_mm);

/// Puts the same in place of the level, near the zero only: values end at `reach_mm` on both sides.
/// @param reach_mm  a few voxels
void keep_distance_band(Volume<float>& level, double reach_mm);

}  // namespace angio::segmentation::detail

#pragma once

#include <vector>

#include "centerline/detail/skeleton.hpp"
#include "centerline/detail/wall.hpp"
#include "centerline/detail/wall_points.hpp"
#include "core/centerline.hpp"

namespace angio::centerline {

/// Turns voxel paths into lines through the middle of the lumen, with radii and section areas.
///
/// Each line in turn (the longest first) is moved to the centres of the largest circles in its
/// normal planes and smoothed, alternately; a later line keeps the points of the line it branches
/// from, leaves it by a smooth curve, and only its own points are moved.
///
/// @param step_mm  distance of points; 0: a quarter of the radius
CenterlineTree trace_lines(const LumenVoxels& lumen, const Skeleton& skeleton, const Wall& wall,
                           const WallPoints& points, double step_mm, const Progress& progress);

}  // namespace angio::centerline

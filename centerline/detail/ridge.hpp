#pragma once

#include <vector>

#include "centerline/detail/polyline.hpp"
#include "centerline/detail/wall_distance.hpp"
#include "core/vec3.hpp"

/// A line that runs beside the middle, where no section was seen that would tell.
namespace angio::centerline {

/// The place in the plane through a point that is deepest in the lumen, climbed to from there: the
/// ridge of the distance to the wall. No step is as long as the wall is far, so none leaves the
/// lumen.
///
/// @param normal  of the plane, unit
/// @param enough  [mm] a depth at which the climb ends; it goes no farther than 1.5 times as much
Vec3 deepest_in_section(const Vec3& place, const Vec3& normal, double enough,
                        const WallDistance& distance_to_wall);

/// The radius [mm] that the vessel has before and behind each point, within four of such radii: the
/// lesser of both.
std::vector<double> radius_around(const Polyline& line, const std::vector<double>& s);

}  // namespace angio::centerline

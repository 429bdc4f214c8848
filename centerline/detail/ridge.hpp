#pragma once

#include <vector>

#include "centerline/detail/line_shape.hpp"
#include "centerline/detail/polyline.hpp"
#include "centerline/detail/wall_distance.hpp"
#include "core/vec3.hpp"

/// A line that runs beside the middle, as where no section was seen that would tell.
namespace angio::centerline {

/// The place in the plane through a point that is deepest in the lumen, climbed to from there: the
/// ridge of the distance to the wall. No step is as long as the wall is far, nor leads out of the
/// lumen: in a throat of a voxel the wall's points are farther apart than it is wide.
///
/// @param normal  of the plane, unit
/// @param enough  [mm] a depth at which the climb ends; it goes no farther than 1.5 times as much
Vec3 deepest_in_section(const Vec3& place, const Vec3& normal, double enough,
                        const WallDistance& distance_to_wall, const Wall& wall);

/// The radius [mm] that the vessel has before and behind each point, within four of such radii: the
/// lesser of both.
std::vector<double> radius_around(const Polyline& line, const std::vector<double>& s);

/// Moves the own points of a line that are nearer to the wall than three quarters of the radius
/// around them to the deepest place of their section, if that is 1.15 times as deep, and makes the
/// line smooth again. A stenosis has none that is deeper. Tips, where the nearest wall is the cap,
/// are left alone.
///
/// @param stiffness  in radii, as settle takes it
/// @return whether any point was moved
bool climb_to_ridge(Line& work, const Surroundings& around, double stiffness);

}  // namespace angio::centerline

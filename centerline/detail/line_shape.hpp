#pragma once

#include <functional>
#include <vector>

#include "centerline/detail/line_starts.hpp"
#include "centerline/detail/lumen_voxels.hpp"
#include "centerline/detail/smooth_curve.hpp"
#include "centerline/detail/wall.hpp"
#include "centerline/detail/wall_distance.hpp"
#include "centerline/detail/wall_points.hpp"

/// What every line is by construction: in the core of its lumen, and without sharp turns.
namespace angio::centerline {

/// All that lines are found from.
struct Surroundings {
  const LumenVoxels& lumen;
  const Wall& wall;
  const WallPoints& points;
  const WallDistance& distance_to_wall;
  /// Distance of points of a finished line [mm], by the radius there.
  std::function<double(double)> last_step;
};

/// Moves the own points of a line onto the smooth curve through the middles. Where that would leave
/// the core of the lumen (places that are at least half as far from the wall as the voxels along
/// which the line was traced) it gives way.
/// @param stiffness  in radii; flat lumens count with their width
void settle(Line& work, const Surroundings& around, Middles middles, double stiffness);

/// Radii that the wall near a point contradicts (a section that looked elsewhere) are set right.
void check_widths(Line& work, const WallDistance& distance_to_wall);

/// Whether the line, out of its parent's lumen, turns by more than 20 degrees from a step to the
/// next, or by more than 34 within a radius.
bool has_turns(const Line& work, const Line* parent);

/// Takes away such turns, by bending the line less there within the lumen's core, and spreads the
/// points anew. Only a line that turns still leaves the middle farther, there alone: a vessel may
/// turn more sharply than any curve through its middles that can be followed.
void straighten(Line& work, const Line* parent, const Surroundings& around,
                const std::function<double(double)>& step);

}  // namespace angio::centerline

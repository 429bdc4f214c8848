#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "centerline/detail/lumen_voxels.hpp"
#include "centerline/detail/point_row.hpp"
#include "centerline/detail/polyline.hpp"
#include "centerline/detail/skeleton.hpp"
#include "centerline/detail/wall.hpp"
#include "centerline/detail/wall_distance.hpp"

/// Lines as they begin, along voxels, before they are moved to the middle.
namespace angio::centerline {

inline constexpr double kWorkStep = 0.4;  ///< of the radius, while centring
/// Radii at a tip that are not centred: caps may be oblique.
inline constexpr double kEndZone = 0.5;

/// A line of the tree; its points [0, shared) are those of its parent from the point `skipped` on.
/// While it is traced it holds no more of its parent than what it can feel.
struct Line {
  Polyline line;  ///< the radius is the inscribed one once measured
  std::vector<double> area;
  std::vector<double> fitted;  ///< inscribed radius freed of the wall's noise [mm]
  std::vector<char> seen;      ///< 1: the section there was seen all round
  PointRow course;             ///< the voxels that it was traced along [mm]
  int parent = -1;
  std::size_t shared = 0;
  std::size_t skipped = 0;
  bool free_start = false;  ///< begins at a wall or at the border of the data
  bool free_end = false;
  std::optional<Vec3> start_rim, end_rim;  ///< middles of open rims: the ends are there
  /// How far from the ends of the course a cap or a dome is felt [mm]; 0 where no wall ends it.
  double start_reach = 0.0, end_reach = 0.0;
  /// The lengths that were drawn straight through caps [mm]: their sections lean into the corners.
  double start_cap = 0.0, end_cap = 0.0;
};

/// Which voxels are a line's own, and whose branch it is.
struct Plan {
  const Skeleton::Chain* chain = nullptr;
  std::size_t first_own = 0;
  int parent = -1;
  int generation = 0;
};

/// The parents of a plan come before it.
std::vector<Plan> plan_lines(const LumenVoxels& lumen, const Skeleton& skeleton);

/// The first line, from the inlet to the farthest outlet.
Line start_line(const LumenVoxels& lumen, const Skeleton& skeleton, const Wall& wall);

/// A later line: the parent's last points up to a little before the branching, then its own voxels.
Line start_branch(const LumenVoxels& lumen, const Plan& plan, const Line& parent, const Wall& wall);

/// Gives a traced line the points of its parent that it skipped.
void take_skipped(Line& work, const Line& parent);

/// The points next to a tip were smoothed only, not centred.
/// @param rim  where the line is to end; none: straight on, at the wall
/// @return the length that goes straight through a cap [mm]; 0: no cap
double redo_end(Polyline& line, const Wall& wall, const WallDistance& distance_to_wall,
                std::size_t least_kept, const std::optional<Vec3>& rim);

/// The first of a line's own points that is outside the tube of its parent.
std::size_t first_outside(const Line& branch, const Line* parent);

}  // namespace angio::centerline

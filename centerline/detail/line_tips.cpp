#include "centerline/detail/line_tips.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "centerline/detail/polyline.hpp"

namespace angio::centerline {
namespace {

/// How many points of a line are inside the closed tip that it ends in. Drawn to the wall it may
/// have gone through it: there, within four radii of the vessel before it, the distance to the wall
/// is hardly anything.
std::size_t count_inside_tip(const Polyline& line, std::size_t least) {
  constexpr double kReach = 4.0, kTouches = 0.35;  // radii; steps
  const std::size_t count = line.points.size();
  double length = 0.0, widest = 0.0;
  std::size_t keep = count;
  for (std::size_t i = count - 1; i > least; --i) {
    const double step = distance(line.points[i - 1], line.points[i]);
    length += step;
    widest = std::max(widest, line.radius[i - 1]);
    if (line.radius[i - 1] < kTouches * step) keep = i - 1;
    if (length > kReach * widest) break;
  }
  return keep;
}

/// Drops points [first, last) of a line, with their numbers.
void drop_points(Line& work, std::size_t first, std::size_t last) {
  work.line.erase(first, last);
  for (std::vector<double>* values : {&work.area, &work.fitted})
    values->erase(values->begin() + std::ptrdiff_t(first), values->begin() + std::ptrdiff_t(last));
  work.seen.erase(work.seen.begin() + std::ptrdiff_t(first),
                  work.seen.begin() + std::ptrdiff_t(last));
}

}  // namespace

void redo_ends(Line& work, const Surroundings& around) {
  const auto redo = [&](std::size_t least_kept, const std::optional<Vec3>& rim,
                        const Vec3& course_end, double& reach) {
    const double cap = redo_end(work.line, around.wall, around.distance_to_wall, least_kept, rim);
    const Vec3& tip = work.line.points.back();
    if (cap > 0.0) reach = std::max(reach, cap + distance(tip, course_end));
    return cap;
  };
  if (work.free_end)
    work.end_cap = redo(work.shared + 2, work.end_rim, work.course.back(), work.end_reach);
  if (!work.free_start) return;
  reverse(work.line);
  work.start_cap = redo(2, work.start_rim, work.course.front(), work.start_reach);
  reverse(work.line);
}

void stay_in_lumen(Line& work, const Wall& wall) {
  const std::size_t count = work.line.points.size(), least = work.shared + 2;
  std::size_t keep = work.free_end && !work.end_rim ? count_inside_tip(work.line, least) : count;
  while (keep > least && wall.beyond_data(work.line.points[keep - 1])) --keep;
  drop_points(work, keep, count);
  if (work.parent >= 0) return;
  std::size_t drop = 0;
  if (work.free_start && !work.start_rim) {
    Polyline tip_last = work.line;
    reverse(tip_last);
    drop = keep - count_inside_tip(tip_last, 2);
  }
  while (drop + 2 < keep && wall.beyond_data(work.line.points[drop])) ++drop;
  drop_points(work, 0, drop);
}

}  // namespace angio::centerline

#include "centerline/detail/ridge.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/parallel.hpp"
#include "core/units.hpp"

namespace angio::centerline {

Vec3 deepest_in_section(const Vec3& place, const Vec3& normal, double enough,
                        const WallDistance& distance_to_wall, const Wall& wall) {
  constexpr int kDirections = 8, kMostSteps = 60;
  constexpr double kFarthest = 1.5, kLeastStep = 0.03, kStay = 0.9, kLeastGain = 0.02;
  const Vec3 aside =
      normalized(cross(normal, std::abs(normal.x) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 up = cross(normal, aside);
  Vec3 best = place;
  double depth = distance_to_wall.at(place, enough), step = kStay * depth;
  for (int round = 0; round < kMostSteps && depth < enough && step > kLeastStep * enough; ++round) {
    Vec3 next = best;
    double next_depth = depth + kLeastGain * step;
    for (int d = 0; d < kDirections; ++d) {
      const double angle = 2.0 * units::kPi * d / kDirections;
      const Vec3 there = best + step * (std::cos(angle) * aside + std::sin(angle) * up);
      if (distance(there, place) > kFarthest * enough) continue;
      const double there_depth = distance_to_wall.at(there, depth);
      if (there_depth <= next_depth) continue;
      next = there;
      next_depth = there_depth;
    }
    if (next == best || !wall.inside(next)) {
      step *= 0.5;
      continue;
    }
    best = next;
    depth = next_depth;
    step = std::min(kStay * depth, 0.5 * enough);
  }
  return best;
}

std::vector<double> radius_around(const Polyline& line, const std::vector<double>& s) {
  constexpr double kReach = 4.0;  // radii
  const std::size_t count = line.points.size();
  std::vector<double> before(count, 0.0), behind(count, 0.0);
  for (std::size_t k = 0; k < count; ++k) {
    const double reach = kReach * line.radius[k];
    for (std::size_t i = k; i < count && s[i] - s[k] <= reach; ++i)
      before[i] = std::max(before[i], line.radius[k]);
    for (std::size_t i = k + 1; i-- > 0 && s[k] - s[i] <= reach;)
      behind[i] = std::max(behind[i], line.radius[k]);
  }
  for (std::size_t i = 0; i < count; ++i) before[i] = std::min(before[i], behind[i]);
  return before;
}

bool climb_to_ridge(Line& work, const Surroundings& around, double stiffness) {
  constexpr double kNear = 0.75, kDeeper = 1.15, kTip = 2.0;
  Polyline& line = work.line;
  const std::vector<double> s = arc_length(line.points);
  const std::vector<double> radius = radius_around(line, s);
  Middles middles{line.points, std::vector<double>(line.points.size(), 1.0)};
  std::vector<char> has_moved(line.points.size(), 0);
  parallel_for_uneven(std::ptrdiff_t(line.points.size() - work.shared), [&](std::ptrdiff_t index) {
    const std::size_t i = work.shared + std::size_t(index);
    const double zone = kTip * radius[i];  // there the nearest wall is the cap
    if ((work.free_start && s[i] < zone) || (work.free_end && s.back() - s[i] < zone)) return;
    const double here = around.distance_to_wall.at(line.points[i], line.radius[i]);
    if (here >= kNear * radius[i]) return;
    const Vec3 deepest =
        deepest_in_section(line.points[i], tangent_at(line, s, i, direction_reach(line, i)),
                           radius[i], around.distance_to_wall, around.wall);
    if (around.distance_to_wall.at(deepest, here) < kDeeper * here) return;
    middles.center[i] = deepest;
    has_moved[i] = 1;
  });
  if (std::find(has_moved.begin(), has_moved.end(), 1) == has_moved.end()) return false;
  line.points = middles.center;
  settle(work, around, std::move(middles), stiffness);
  return true;
}

}  // namespace angio::centerline

#include "centerline/detail/line_shape.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "centerline/detail/point_row.hpp"
#include "centerline/detail/polyline.hpp"
#include "centerline/detail/ridge.hpp"
#include "core/centerline.hpp"
#include "core/parallel.hpp"

namespace angio::centerline {

namespace {

/// Whether no wall is between two places.
bool sees(const Wall& wall, const Vec3& from, const Vec3& to) {
  constexpr double kStep = 0.5;  // voxels
  const int steps = int(std::ceil(distance(from, to) / (kStep * wall.resolution())));
  for (int n = 1; n < steps; ++n)
    if (!wall.inside(from + (double(n) / steps) * (to - from))) return false;
  return true;
}

/// How deep in the lumen a line must stay, as a share of how deep the voxels are along which it was
/// traced.
constexpr double kCore = 0.5;

/// Whether a place is in the lumen that the line was traced along, and not in one beside it, and
/// not much nearer to its wall than the middle there.
/// @param core  share of the middle's depth
bool is_in_core(const Line& work, const Surroundings& around, const Vec3& place,
                double core = kCore) {
  if (!around.wall.inside(place)) return false;
  const Vec3& middle = work.course[work.course.nearest(place)];
  const double depth = around.lumen.depth_at(middle);
  if (distance(place, middle) > depth && !sees(around.wall, place, middle)) return false;
  // The course runs into the edge of a cap, the line to its middle.
  if (distance(place, work.course.back()) < work.end_reach ||
      distance(place, work.course.front()) < work.start_reach)
    return true;
  const double slack = 0.5 * around.wall.resolution();
  return around.lumen.depth_at(place) >= core * depth - slack;
}

/// Takes tips that are far from where the line was traced to back there.
void return_tips(const Line& work, std::vector<Vec3>& curve) {
  constexpr double kFar = 2.0;  // radii, beyond the reach of the cap
  const Polyline& line = work.line;
  const auto is_far = [&](const Vec3& tip, const Vec3& traced, double reach, double radius) {
    return distance(tip, traced) > reach + kFar * radius;
  };
  if (!work.end_rim && is_far(curve.back(), work.course.back(), work.end_reach, line.radius.back()))
    curve.back() = work.course.back();
  if (work.free_start && !work.start_rim &&
      is_far(curve.front(), work.course.front(), work.start_reach, line.radius.front()))
    curve.front() = work.course.front();
}

/// The place of the course that each point of a curve is beside: those for which the sum of squared
/// distances is least while the course is only followed onwards. The nearest place may be on
/// another limb, where the course comes back beside itself.
std::vector<std::size_t> follow_course(const PointRow& course, const std::vector<Vec3>& curve) {
  const std::size_t count = course.size();
  std::vector<double> cost(count, 0.0);
  std::vector<std::vector<std::uint32_t>> before;  // the place of the point before, of each place
  for (const Vec3& point : curve) {
    std::vector<std::uint32_t>& from = before.emplace_back(count);
    std::uint32_t best = 0;
    double least = cost.front();
    for (std::size_t j = 0; j < count; ++j) {
      if (cost[j] < least) {
        least = cost[j];
        best = std::uint32_t(j);
      }
      from[j] = best;
      cost[j] = least + norm_squared(course[j] - point);
    }
  }
  std::vector<std::size_t> beside(curve.size());
  auto at = std::size_t(std::min_element(cost.begin(), cost.end()) - cost.begin());
  for (std::size_t k = curve.size(); k-- > 0;) {
    beside[k] = at;
    at = before[k][at];
  }
  return beside;
}

/// Takes stretches that left the core back to the voxels that the line was traced along, from
/// where the line runs beside them to where it does so again.
void return_to_course(const Line& work, const Surroundings& around, std::vector<Vec3>& curve,
                      double core = kCore) {
  return_tips(work, curve);
  const std::size_t least = std::max<std::size_t>(work.shared, 1);
  std::vector<std::size_t> place;  // on the course
  const auto is_beside = [&](std::size_t k) {
    const double near = std::max(2.0 * around.wall.resolution(), 0.3 * work.line.radius[k]);
    return is_in_core(work, around, curve[k], core) &&
           distance(curve[k], work.course[place[k]]) < near;
  };
  for (std::size_t i = least; i + 1 < curve.size(); ++i) {
    if (is_in_core(work, around, curve[i], core)) continue;
    if (place.empty()) place = follow_course(work.course, curve);
    std::size_t begin = i, end = i;  // points [begin, end) are put anew
    while (begin > least && !is_beside(begin - 1)) --begin;
    while (end + 1 < curve.size() && !is_beside(end)) ++end;
    const auto from = double(place[begin - 1]), to = double(place[end]);
    for (std::size_t k = begin; k < end; ++k) {
      const double at = from + (to - from) * double(k - begin + 1) / double(end - begin + 1);
      const auto low = std::min(std::size_t(at), work.course.size() - 1);
      const Vec3& next = work.course[std::min(low + 1, work.course.size() - 1)];
      curve[k] = work.course[low] + (at - double(low)) * (next - work.course[low]);
    }
    i = end;
  }
}

/// A line's stiffness in points, given in radii; flat lumens count with their width.
std::vector<double> stiffness_in_points(const Polyline& line, double in_radii) {
  const std::size_t count = line.points.size();
  std::vector<double> stiffness(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t a = i > 0 ? i - 1 : i, b = std::min(i + 1, count - 1);
    const double step =
        std::max(distance(line.points[a], line.points[b]) / double(std::max<std::size_t>(b - a, 1)),
                 1e-3 * line.radius[i]);
    stiffness[i] = std::clamp(in_radii * direction_reach(line, i) / step, 0.3, 12.0);
  }
  return stiffness;
}

/// Middles farther than this from the line count nothing.
std::vector<double> tolerances(const Polyline& line) {
  std::vector<double> result = line.extent;
  for (double& value : result) value *= 0.3;
  return result;
}

/// The most that a line may turn: cosines.
struct MostTurn {
  double step, radius;  ///< from a step to the next, and within a radius
};
constexpr MostTurn kWished{0.940, 0.829};  ///< 20 and 34 degrees
constexpr MostTurn kMust{0.914, 0.777};    ///< 24 and 39 degrees

/// The own points round which a line turns more; in its parent's lumen it may.
std::vector<char> find_turns(const Polyline& line, std::size_t first, const MostTurn& most_turn) {
  const std::size_t count = line.points.size();
  std::vector<char> turns(count, 0);
  std::vector<Vec3> along(count);
  for (std::size_t i = 0; i + 1 < count; ++i)
    along[i] = normalized(line.points[i + 1] - line.points[i]);
  for (std::size_t i = std::max<std::size_t>(first, 1); i + 1 < count; ++i) {
    double most = most_turn.step, length = 0.0;
    for (std::size_t k = i; k + 1 < count && length <= line.radius[i]; ++k) {
      if (dot(along[i - 1], along[k]) < most)
        std::fill(turns.begin() + std::ptrdiff_t(i), turns.begin() + std::ptrdiff_t(k) + 1, 1);
      length += distance(line.points[k], line.points[k + 1]);
      most = most_turn.radius;
    }
  }
  return turns;
}

/// The points around which a vessel turns back: its line by more than 90 degrees over three radii,
/// and nowhere by more than 65 within one, as no tube can whose bend is no tighter than it is wide.
/// No curve in the vessel turns less there, so a shorter one would only run along its inner wall.
std::vector<char> find_turns_back(const Polyline& line) {
  constexpr double kReach = 1.5, kMost = 0.423;  // radii; a cosine
  const std::size_t count = line.points.size();
  const std::vector<double> s = arc_length(line.points), radius = radius_around(line, s);
  const auto along = [&](std::size_t i) {
    const std::size_t k = std::min(i, count - 2);
    return normalized(line.points[k + 1] - line.points[k]);
  };
  const auto is_a_bend = [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i <= last; ++i)
      for (std::size_t k = i + 1; k <= last && s[k] - s[i] <= radius[i]; ++k)
        if (dot(along(i), along(k)) < kMost) return false;
    return true;
  };
  std::vector<char> turns_back(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const double reach = kReach * radius[i];
    if (s[i] < 1.5 * reach || s.back() - s[i] < 1.5 * reach) continue;
    const auto at = [&](double abscissa) {
      return std::size_t(std::lower_bound(s.begin(), s.end(), abscissa) - s.begin());
    };
    const std::size_t before = at(s[i] - reach), behind = at(s[i] + reach);
    if (dot(tangent_at(line, s, before, 0.5 * reach), tangent_at(line, s, behind, 0.5 * reach)) >
            0.0 ||
        !is_a_bend(before, behind))
      continue;
    std::fill(turns_back.begin() + std::ptrdiff_t(at(s[i] - 1.5 * reach)),
              turns_back.begin() + std::ptrdiff_t(at(s[i] + 1.5 * reach)), 1);
  }
  return turns_back;
}

/// How deep in the lumen a line must stay while it is straightened: where it turns back, a share of
/// what its section is deep, which is what keeps it near the middle of a bend.
class LeastDepths {
 public:
  LeastDepths(const Line& work, const Surroundings& around, double share)
      : lumen_(around.lumen), points_(work.line.points), least_(points_.size(), 0.0) {
    constexpr double kSlack = 0.5;  // voxels
    const std::vector<char> turns_back = find_turns_back(work.line);
    const std::vector<double> s = arc_length(work.line.points),
                              radius = radius_around(work.line, s);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (turns_back[i] == 0) continue;
      const Vec3 normal = tangent_at(work.line, s, i, direction_reach(work.line, i));
      const Vec3 deepest =
          deepest_in_section(points_[i], normal, radius[i], around.distance_to_wall, around.wall);
      least_[i] = share * lumen_.depth_at(deepest) - kSlack * around.wall.resolution();
    }
    most_ = *std::max_element(least_.begin(), least_.end());
  }

  [[nodiscard]] bool allow(const Vec3& place) const {
    const double depth = lumen_.depth_at(place);
    return depth >= most_ || depth >= least_[points_.nearest(place)];
  }

 private:
  const LumenVoxels& lumen_;
  PointRow points_;            ///< of the line before [mm]
  std::vector<double> least_;  ///< [mm]
  double most_ = 0.0;          ///< of these
};

/// The points of a line within two radii of those that are marked.
std::vector<char> within_two_radii(const Polyline& line, const std::vector<char>& marked) {
  constexpr double kReach = 2.0;
  const std::vector<double> s = arc_length(line.points);
  std::vector<char> near(marked.size(), 0);
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (marked[i] == 0) continue;
    const double reach = kReach * line.radius[i];
    const auto first = std::lower_bound(s.begin(), s.end(), s[i] - reach) - s.begin(),
               last = std::upper_bound(s.begin(), s.end(), s[i] + reach) - s.begin();
    std::fill(near.begin() + first, near.begin() + last, 1);
  }
  return near;
}

/// Where a point goes so that the curve bends less there: across the curve down the sum of
/// |x[k - m] - 2 x[k] + x[k + m]|^2; along it to the middle of its neighbours.
Vec3 bent_less(const std::vector<Vec3>& points, std::size_t i, std::size_t m) {
  const auto& x = points;
  const Vec3 evenly = 0.25 * (x[i - 1] + x[i + 1] - 2.0 * x[i]);
  if (m == 0 || x[i + 1] == x[i - 1]) return x[i] + evenly;  // no way along it
  const Vec3 straighter =
      (1.0 / 16.0) * (4.0 * (x[i - m] + x[i + m]) - 6.0 * x[i] - x[i - 2 * m] - x[i + 2 * m]);
  const Vec3 along = normalized(x[i + 1] - x[i - 1]);
  return x[i] + straighter + dot(evenly - straighter, along) * along;
}

/// Bends the curve less around places where it turns too sharply, as far as the lumen's core lets
/// it and it stays deep enough. Unlike a curve that is shortened, which turns all at once where it
/// meets the core's edge, one that bends less takes a turn as wide as the core is.
void relax_turns(Line& work, const Line* parent, const Surroundings& around,
                 const LeastDepths& depths, double core, const MostTurn& most_turn) {
  constexpr int kMostSweeps = 200;
  Polyline& line = work.line;
  const std::size_t count = line.points.size(), first = first_outside(work, parent);
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    const std::vector<char> near = within_two_radii(line, find_turns(line, first, most_turn));
    bool has_moved = false;
    const std::vector<Vec3> before = line.points;
    for (std::size_t i = std::max<std::size_t>(work.shared, 1); i + 1 < count; ++i) {
      if (near[i] == 0) continue;
      const std::size_t room = std::min(i, count - 1 - i);
      const auto m = std::min<std::size_t>(std::size_t(sweep % 3) + 1, room / 2);
      const Vec3 next = bent_less(before, i, m);
      if (!is_in_core(work, around, next, core) || !depths.allow(next)) continue;
      line.points[i] = next;
      has_moved = true;
    }
    if (!has_moved) return;
  }
}

}  // namespace

void settle(Line& work, const Surroundings& around, Middles middles, double stiffness_in_radii) {
  constexpr int kRepairs = 8;
  Polyline& line = work.line;
  const std::vector<double> tolerance = tolerances(line);
  std::vector<double> stiffness = stiffness_in_points(line, stiffness_in_radii);
  const std::vector<Vec3> before = line.points;
  std::vector<Vec3> curve;
  for (int repair = 0;; ++repair) {
    curve = smooth_curve(before, middles, work.shared, stiffness, tolerance);
    bool is_fine = true;
    for (std::size_t i = std::max<std::size_t>(work.shared, 1); i + 1 < curve.size(); ++i) {
      if (is_in_core(work, around, curve[i])) continue;
      is_fine = false;
      middles.center[i] = is_in_core(work, around, before[i])
                              ? before[i]
                              : work.course[work.course.nearest(curve[i])];
      for (std::size_t k = i - std::min<std::size_t>(i - work.shared, 2);
           k < std::min(i + 3, curve.size()); ++k) {
        stiffness[k] = std::max(0.8 * stiffness[k], 0.3);
        middles.weight[k] = std::min(std::max(2.0 * middles.weight[k], 1.0), 1e3);
      }
    }
    if (is_fine || repair == kRepairs) break;
  }
  return_to_course(work, around, curve);
  line.points = std::move(curve);
}

namespace {

/// Near a cap the wall that is nearest is the cap: there the vessel is as wide as before it.
void widen_tip(Polyline& line, double reach) {
  const std::vector<double> s = arc_length(line.points);
  std::size_t from = 0;
  while (from + 1 < s.size() && s[from] < 0.5 * reach) ++from;
  for (std::size_t i = 0; i < from; ++i) {
    line.radius[i] = std::max(line.radius[i], line.radius[from]);
    line.extent[i] = std::max(line.extent[i], line.extent[from]);
  }
}

}  // namespace

void check_widths(Line& work, const WallDistance& distance_to_wall) {
  constexpr double kMost = 2.5;  // the point may be beside the middle, and the wall noisy
  Polyline& line = work.line;
  parallel_for_uneven(std::ptrdiff_t(line.points.size() - work.shared), [&](std::ptrdiff_t index) {
    const std::size_t i = work.shared + std::size_t(index);
    const double here = distance_to_wall.at(line.points[i], line.radius[i]);
    line.radius[i] = std::clamp(line.radius[i], here, kMost * here);
    line.extent[i] = std::max(line.extent[i], line.radius[i]);
  });
  if (work.free_start) widen_tip(line, work.start_reach);
  if (!work.free_end) return;
  reverse(line);
  widen_tip(line, work.end_reach);
  reverse(line);
}

namespace {

bool has_turns(const Line& work, const Line* parent, const MostTurn& most_turn) {
  const std::vector<char> turns = find_turns(work.line, first_outside(work, parent), most_turn);
  return std::find(turns.begin(), turns.end(), 1) != turns.end();
}

}  // namespace

bool has_turns(const Line& work, const Line* parent) { return has_turns(work, parent, kWished); }

void straighten(Line& work, const Line* parent, const Surroundings& around,
                const std::function<double(double)>& step) {
  constexpr int kMostRounds = 6;
  struct Shares {
    double core;   ///< of the traced voxels' depth
    double depth;  ///< of a section's depth, where the vessel turns back
    MostTurn most_turn;
  };
  // A line that still turns more than it must not may leave the middle farther.
  constexpr Shares kShares[] = {
      {kCore, 0.8, kWished}, {kCore, 0.7, kWished}, {0.3, 0.5, kMust}, {0.1, 0.5, kMust}};
  for (const auto& [core, depth, most_turn] : kShares) {
    if (!has_turns(work, parent, most_turn)) return;
    const LeastDepths depths(work, around, depth);
    for (int round = 0; round < kMostRounds && has_turns(work, parent, most_turn); ++round) {
      return_to_course(work, around, work.line.points, core);
      relax_turns(work, parent, around, depths, core, most_turn);
      check_widths(work, around.distance_to_wall);
      resample(work.line, work.shared, step);
    }
  }
}

}  // namespace angio::centerline

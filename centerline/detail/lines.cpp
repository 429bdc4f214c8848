#include "centerline/detail/lines.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "centerline/detail/polyline.hpp"
#include "centerline/detail/section.hpp"
#include "centerline/detail/tube_model.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

constexpr int kRounds = 6;              // of centring by rays and smoothing
constexpr int kFitRounds = 5;           // of centring by the tube model, at most
constexpr int kFlatFitRounds = 15;      // where the lumen is flat: each goes some way along it
constexpr double kFlat = 2.0;           // extent over radius
constexpr double kSettled = 0.02;       // of the extent: a line that moves less (rms) has settled
constexpr double kWorkStep = 0.4;       // of the radius, while centring
constexpr double kFinalStep = 0.25;     // of the radius
constexpr double kMostLastMove = 0.15;  // of the extent, when the numbers are taken
constexpr double kEndZone = 0.5;        // radii at a tip that are not centred: caps may be oblique

/// A line of the tree; its points [0, shared) are those of its parent.
struct Line {
  Polyline line;  ///< the radius is the inscribed one once measured
  std::vector<double> area;
  int parent = -1;
  std::size_t shared = 0;
  bool free_start = false;  ///< begins at a wall or at the border of the data
  bool free_end = false;
};

Polyline from_voxels(const LumenVoxels& lumen, const std::vector<int>& voxels) {
  Polyline line;
  for (const int v : voxels) line.push_back(lumen.position(v), double(lumen.depth[std::size_t(v)]));
  return line;
}

/// Goes straight on from the last point to the wall, or to the border of the data.
void extend_to_wall(Polyline& line, const Wall& wall, double dropped) {
  const double radius = line.radius.back();
  const Vec3 tip = line.points.back();
  const Vec3 direction = end_tangent(line, radius);
  const double longest = dropped + 2.0 * radius;
  const double step = 0.25 * wall.resolution();
  double reach = wall.ray(tip, direction, longest);
  if (reach >= longest && !wall.beyond_data(tip + reach * direction)) reach = dropped;
  while (reach > 0.0 && wall.beyond_data(tip + reach * direction)) reach -= step;
  if (reach <= step) return;
  const int count = std::max(1, int(std::ceil(reach / std::max(kWorkStep * radius, step))));
  for (int i = 1; i <= count; ++i) line.push_back(tip + (reach * i / count) * direction, radius);
}

void cut_and_extend(Polyline& line, const Wall& wall, std::size_t keep) {
  if (keep < 2 || keep >= line.points.size()) return;
  const double dropped = distance(line.points.back(), line.points[keep - 1]);
  line.resize(keep);
  extend_to_wall(line, wall, dropped);
}

/// A voxel path runs into the edge of the cap: replace its end by a straight piece.
void straighten_end(Polyline& line, const Wall& wall, std::size_t least_kept) {
  Polyline tip_first = line;
  reverse(tip_first);
  const auto cap = std::size_t(end_of_cap(tip_first.points, tip_first.radius));
  cut_and_extend(line, wall, std::max(line.points.size() - cap, least_kept));
}

/// The points next to a tip were smoothed only, not centred.
void redo_end(Polyline& line, const Wall& wall, std::size_t least_kept) {
  const std::vector<double> s = arc_length(line.points);
  const double zone = std::max(kEndZone * line.radius.back(), wall.resolution());
  std::size_t keep = line.points.size();
  while (keep > least_kept && s.back() - s[keep - 1] < zone) --keep;
  cut_and_extend(line, wall, keep);
}

/// The first of a line's own points that is outside the tube of its parent.
std::size_t first_outside(const Line& branch, const Line* parent) {
  if (parent == nullptr) return 0;
  const std::vector<Vec3>& points = branch.line.points;
  for (std::size_t i = branch.shared; i < points.size(); ++i)
    if (!inside_tube(parent->line.points, parent->line.radius, 0, points[i])) return i;
  return points.size() - 1;
}

/// Moves each own point that is out of the parent's lumen towards the centre of its section.
void center_points(Line& work, const Line* parent, const Wall& wall) {
  Polyline& line = work.line;
  const std::vector<double> s = arc_length(line.points);
  const std::size_t first = std::max(work.shared, first_outside(work, parent));
  std::vector<Vec3> moved = line.points;
  std::vector<double> radius = line.radius, extent = line.extent;
  parallel_for_uneven(std::ptrdiff_t(line.points.size() - first), [&](std::ptrdiff_t index) {
    const std::size_t i = first + std::size_t(index);
    if (work.free_start && s[i] < kEndZone * line.radius[i]) return;
    if (work.free_end && s.back() - s[i] < kEndZone * line.radius[i]) return;
    SectionOptions options;
    options.expected = std::max(line.radius[i], wall.resolution());
    options.extent = line.extent[i];
    options.refinements = 0;
    const Section section = measure_section(
        wall, line.points[i], tangent_at(line, s, i, direction_reach(line, i)), options);
    if (!section.valid) return;
    moved[i] += 0.8 * (section.center - moved[i]);
    radius[i] = section.inscribed_radius;
    extent[i] = section.extent;
  });
  line.points = std::move(moved);
  line.radius = std::move(radius);
  line.extent = std::move(extent);
}

/// Moves each own point that is out of the parent's lumen to the middle of the tube fitted to the
/// wall round it, and takes its radius (and, when measuring, its area) from there.
struct FitRound {
  std::vector<char> fitted;  ///< 1: the model saw enough wall
  double shift = 0.0;        ///< rms of the points' moves, in extents
  double flat_shift = 0.0;   ///< the same where the lumen is flat
};

FitRound fit_points(Line& work, const Line* parent, const Wall& wall, const WallPoints& points,
                    TubeEffort effort) {
  Polyline& line = work.line;
  const std::vector<double> s = arc_length(line.points);
  const std::size_t first = std::max(work.shared, first_outside(work, parent));
  std::vector<TubeSection> sections(line.points.size());
  parallel_for_uneven(std::ptrdiff_t(line.points.size() - first), [&](std::ptrdiff_t index) {
    const std::size_t i = first + std::size_t(index);
    const LocalCurve curve = fit_curve(line, s, i, 1.2 * direction_reach(line, i));
    sections[i] = fit_tube(points, curve, line.radius[i], line.extent[i], &wall, effort);
  });
  FitRound round;
  round.fitted.assign(line.points.size(), 0);
  double squares = 0.0, flat_squares = 0.0;
  int flat_count = 0;
  for (std::size_t i = first; i < line.points.size(); ++i) {
    if (!sections[i].valid) continue;
    // A settled line moves little; what still jumps, at a ragged mouth, would become a hook.
    if (effort == TubeEffort::measure &&
        distance(sections[i].center, line.points[i]) > kMostLastMove * sections[i].extent)
      continue;
    round.fitted[i] = 1;
    // While a line moves, its tips are left alone, so that they cannot creep along the cap.
    const double zone = effort == TubeEffort::measure ? 0.0 : kEndZone * line.radius[i];
    if (!(work.free_start && s[i] < zone) && !(work.free_end && s.back() - s[i] < zone)) {
      const double square = norm_squared(sections[i].center - line.points[i]) /
                            (sections[i].extent * sections[i].extent);
      squares += square;
      if (sections[i].extent > kFlat * sections[i].inscribed_radius) {
        flat_squares += square;
        ++flat_count;
      }
      line.points[i] = sections[i].center;
    }
    line.radius[i] = sections[i].inscribed_radius;
    line.extent[i] = sections[i].extent;
    if (effort == TubeEffort::measure) work.area[i] = sections[i].area;
  }
  round.shift = std::sqrt(squares / double(line.points.size() - first));
  if (flat_count > 0) round.flat_shift = std::sqrt(flat_squares / flat_count);
  return round;
}

/// Leaves the parent by a smooth curve from the last shared point to the mouth of the branch.
void bridge_mouth(Line& work, const Line& parent, const Wall& wall) {
  const std::size_t mouth = first_outside(work, &parent);
  if (mouth <= work.shared) return;
  Polyline& line = work.line;
  const std::size_t anchor = work.shared - 1;
  const std::vector<double> s = arc_length(line.points);
  const auto count = int(mouth - work.shared);
  const Vec3 leave = normalized(line.points[anchor] - line.points[anchor > 0 ? anchor - 1 : 0]);
  const Vec3 enter = tangent_at(line, s, mouth, 0.5 * line.radius[mouth]);
  const std::vector<Vec3> curve =
      bridge(line.points[anchor], leave, line.points[mouth], enter, count);
  for (const Vec3& p : curve)
    if (wall.ray(p, leave, wall.resolution()) <= 0.0) return;  // stays as it was smoothed
  std::copy(curve.begin(), curve.end(), line.points.begin() + std::ptrdiff_t(work.shared));
}

void refine(Line& work, const Line* parent, const Wall& wall, const WallPoints& points,
            double step_mm) {
  const auto work_step = [&](double r) { return std::max(kWorkStep * r, 0.4 * wall.resolution()); };
  const std::size_t least_kept = work.shared + 2;
  for (int round = 0; round < kRounds; ++round) {
    resample(work.line, work.shared, work_step);
    smooth(work.line, work.shared, 2);
    center_points(work, parent, wall);
  }
  for (int round = 1; round <= kFlatFitRounds; ++round) {
    resample(work.line, work.shared, work_step);
    smooth(work.line, work.shared, 2);  // against hooks at mouths; the fit centres again
    const FitRound fit = fit_points(work, parent, wall, points, TubeEffort::center);
    if (round > 1 && fit.shift < kSettled) break;
    if (round >= kFitRounds && fit.flat_shift < kSettled) break;
  }
  if (parent != nullptr) bridge_mouth(work, *parent, wall);
  if (work.free_end) redo_end(work.line, wall, least_kept);
  if (work.free_start) {
    reverse(work.line);
    redo_end(work.line, wall, 2);
    reverse(work.line);
  }
  resample(work.line, work.shared, [&](double r) {
    return step_mm > 0.0 ? step_mm : std::max(kFinalStep * r, 0.25 * wall.resolution());
  });
}

/// Where a plane misses the lumen (right at a cap), the nearest good section stands in.
void fill_gaps(Line& work) {
  const std::size_t count = work.area.size();
  for (std::size_t i = std::max<std::size_t>(work.shared, 1); i < count; ++i)
    if (work.area[i] <= 0.0) {
      work.area[i] = work.area[i - 1];
      work.line.radius[i] = work.line.radius[i - 1];
    }
  for (std::size_t i = count - 1; i-- > 0;)
    if (work.area[i] <= 0.0) {
      work.area[i] = work.area[i + 1];
      work.line.radius[i] = work.line.radius[i + 1];
    }
  for (std::size_t i = 0; i < count; ++i)
    if (work.area[i] <= 0.0) work.area[i] = units::kPi * work.line.radius[i] * work.line.radius[i];
}

/// Inside its parent's tube a branch's line is a curve from one vessel to the other and in the
/// middle of neither, so the room around it says nothing of the vessel: at least, it is as wide as
/// on the way from the one radius to the other.
void widen_mouth(Line& work, const Line& parent, const std::vector<double>& s) {
  const std::size_t anchor = work.shared - 1, mouth = first_outside(work, &parent);
  std::vector<double>& radius = work.line.radius;
  for (std::size_t i = work.shared; i < mouth; ++i) {
    const double t = (s[i] - s[anchor]) / (s[mouth] - s[anchor]);
    radius[i] = std::max(radius[i], (1.0 - t) * radius[anchor] + t * radius[mouth]);
    work.area[i] = std::max(work.area[i], units::kPi * radius[i] * radius[i]);
  }
}

/// The numbers that are kept: by the tube model, and where it sees too little wall (in branchings,
/// at ragged ends) by rays.
void measure(Line& work, const Line* parent, const Wall& wall, const WallPoints& points) {
  work.area.resize(work.line.points.size(), 0.0);
  const std::vector<char> fitted =
      fit_points(work, parent, wall, points, TubeEffort::measure).fitted;
  const Polyline& line = work.line;
  const std::vector<double> s = arc_length(line.points);
  std::vector<double> radius = line.radius;
  parallel_for_uneven(std::ptrdiff_t(line.points.size() - work.shared), [&](std::ptrdiff_t index) {
    const std::size_t i = work.shared + std::size_t(index);
    if (fitted[i] != 0) return;
    SectionOptions options;
    options.ray_count = 64;
    options.expected = std::max(line.radius[i], wall.resolution());
    const Section section = measure_section(
        wall, line.points[i], tangent_at(line, s, i, direction_reach(line, i)), options);
    // From beside the middle, the wall that is near says nothing of the vessel's width.
    if (!section.valid || distance(section.center, line.points[i]) > 0.5 * section.inscribed_radius)
      return;
    radius[i] = section.inscribed_radius;
    work.area[i] = section.area;
  });
  work.line.radius = std::move(radius);
  fill_gaps(work);
  if (parent != nullptr) widen_mouth(work, *parent, s);
}

/// A tip that was centred after it had been drawn to the border of the data may lie beyond it.
void stay_in_data(Line& work, const Wall& wall) {
  std::size_t keep = work.line.points.size(), drop = 0;
  while (keep > work.shared + 2 && wall.beyond_data(work.line.points[keep - 1])) --keep;
  work.line.resize(keep);
  work.area.resize(keep);
  if (work.parent >= 0) return;
  while (drop + 2 < keep && wall.beyond_data(work.line.points[drop])) ++drop;
  work.line.erase(0, drop);
  work.area.erase(work.area.begin(), work.area.begin() + std::ptrdiff_t(drop));
}

/// The first line, from the inlet to the farthest outlet.
Line start_line(const LumenVoxels& lumen, const Skeleton& skeleton, const Wall& wall) {
  Line work;
  work.line = from_voxels(lumen, skeleton.chains.front().voxels);
  work.free_start = skeleton.starts_at_end;
  work.free_end = !skeleton.chains.front().ends_at_cut;
  if (work.free_end) straighten_end(work.line, wall, 2);
  if (work.free_start) {
    reverse(work.line);
    straighten_end(work.line, wall, 2);
    reverse(work.line);
  }
  return work;
}

/// Paths through neighbouring voxels may run side by side in one vessel: a branch begins behind the
/// last of its voxels that is still on its parent's line, and not where the paths part.
/// @return the first voxel that is the branch's own
std::size_t leaves_line(const LumenVoxels& lumen, const Skeleton::Chain& chain,
                        std::size_t first_own, const Line& parent) {
  const Vec3 h = lumen.geometry.spacing;
  const double voxel = std::max({h.x, h.y, h.z});
  const Polyline& line = parent.line;
  std::size_t own = first_own;
  for (std::size_t i = first_own; i < chain.voxels.size(); ++i) {
    const Vec3 p = lumen.position(chain.voxels[i]);
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < line.points.size(); ++k)
      if (norm_squared(line.points[k] - p) < norm_squared(line.points[nearest] - p)) nearest = k;
    const double away = distance(line.points[nearest], p);
    if (away > line.radius[nearest]) break;
    if (away < std::max(0.25 * line.radius[nearest], voxel)) own = i + 1;
  }
  return std::min(own, chain.voxels.size() - 1);
}

/// A later line: the parent's points up to a little before the branching, then its own voxels.
Line start_branch(const LumenVoxels& lumen, const Skeleton::Chain& chain, std::size_t parts_at,
                  int parent_index, const Line& parent, const Wall& wall) {
  const std::size_t first_own = leaves_line(lumen, chain, parts_at, parent);
  const Vec3 junction = lumen.position(chain.voxels[first_own > 0 ? first_own - 1 : 0]);
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < parent.line.points.size(); ++i)
    if (distance(parent.line.points[i], junction) < distance(parent.line.points[nearest], junction))
      nearest = i;
  std::size_t leave = nearest;
  while (leave > 0 && distance(parent.line.points[leave], parent.line.points[nearest]) <
                          0.5 * parent.line.radius[nearest])
    --leave;
  Line work;
  work.parent = parent_index;
  work.shared = leave + 1;
  work.free_end = !chain.ends_at_cut;
  const auto take = std::ptrdiff_t(work.shared);
  work.line = parent.line;
  work.line.resize(work.shared);
  work.area.assign(parent.area.begin(), parent.area.begin() + take);
  for (std::size_t i = first_own; i < chain.voxels.size(); ++i)
    work.line.push_back(lumen.position(chain.voxels[i]),
                        double(lumen.depth[std::size_t(chain.voxels[i])]));
  // The voxels inside the parent run along its middle, maybe past the mouth: go straight instead.
  work.line.erase(work.shared, std::min(first_outside(work, &parent), work.line.points.size() - 1));
  if (work.free_end) straighten_end(work.line, wall, work.shared + 1);
  return work;
}

/// Which voxels are a line's own, and whose branch it is.
struct Plan {
  const Skeleton::Chain* chain = nullptr;
  std::size_t first_own = 0;
  int parent = -1;
  int generation = 0;
};

std::vector<Plan> plan_lines(const LumenVoxels& lumen, const Skeleton& skeleton) {
  std::vector<int> owner(std::size_t(lumen.count()), -1);
  std::vector<Plan> plans;
  for (const Skeleton::Chain& chain : skeleton.chains) {
    const int index = int(plans.size());
    Plan plan;
    plan.chain = &chain;
    std::size_t& own = plan.first_own;
    while (own < chain.voxels.size() && owner[std::size_t(chain.voxels[own])] >= 0) ++own;
    if (index > 0 && own == chain.voxels.size()) continue;  // an outlet on another line
    plan.parent = own > 0 ? owner[std::size_t(chain.voxels[own - 1])] : (index > 0 ? 0 : -1);
    if (plan.parent >= 0) plan.generation = plans[std::size_t(plan.parent)].generation + 1;
    for (std::size_t i = own; i < chain.voxels.size(); ++i)
      owner[std::size_t(chain.voxels[i])] = index;
    plans.push_back(plan);
  }
  return plans;
}

CenterlinePath to_path(const Line& line, int id) {
  CenterlinePath path;
  path.id = id;
  path.points = line.line.points;
  path.inscribed_radius = line.line.radius;
  path.section_area = line.area;
  path.abscissa = arc_length(path.points);
  for (const double area : path.section_area)
    path.equivalent_radius.push_back(std::sqrt(area / units::kPi));
  return path;
}

}  // namespace

CenterlineTree trace_lines(const LumenVoxels& lumen, const Skeleton& skeleton, const Wall& wall,
                           const WallPoints& points, double step_mm, const Progress& progress) {
  const std::vector<Plan> plans = plan_lines(lumen, skeleton);
  std::vector<Line> lines(plans.size());
  const auto trace_line = [&](std::size_t index) {
    const Plan& plan = plans[index];
    const Line* parent = plan.parent >= 0 ? &lines[std::size_t(plan.parent)] : nullptr;
    Line work = parent == nullptr
                    ? start_line(lumen, skeleton, wall)
                    : start_branch(lumen, *plan.chain, plan.first_own, plan.parent, *parent, wall);
    refine(work, parent, wall, points, step_mm);
    measure(work, parent, wall, points);
    stay_in_data(work, wall);
    lines[index] = std::move(work);
  };
  // Lines need their parent's only: those of one generation are traced at once.
  std::size_t done = 0;
  for (int generation = 0; done < plans.size(); ++generation) {
    std::vector<std::size_t> now;
    for (std::size_t i = 0; i < plans.size(); ++i)
      if (plans[i].generation == generation) now.push_back(i);
    if (now.size() == 1)
      trace_line(now.front());  // its points are fitted in parallel
    else
      parallel_for_uneven(std::ptrdiff_t(now.size()),
                          [&](std::ptrdiff_t i) { trace_line(now[std::size_t(i)]); });
    done += now.size();
    progress.report(0.4 + 0.6 * double(done) / double(plans.size()), "centring lines");
  }
  std::vector<CenterlinePath> paths;
  for (const Line& line : lines) paths.push_back(to_path(line, 0));
  std::stable_sort(paths.begin(), paths.end(), [](const auto& a, const auto& b) {
    return a.abscissa.back() > b.abscissa.back();
  });
  CenterlineTree tree;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    paths[i].id = int(i);
    tree.paths.push_back(std::move(paths[i]));
  }
  return tree;
}

}  // namespace angio::centerline

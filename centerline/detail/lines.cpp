#include "centerline/detail/lines.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "centerline/detail/line_starts.hpp"
#include "centerline/detail/polyline.hpp"
#include "centerline/detail/section.hpp"
#include "centerline/detail/tube_model.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

constexpr int kRounds = 6;              // of centring by rays and smoothing
constexpr int kFitRounds = 5;           // of centring by the tube model, at most
constexpr int kFlatFitRounds = 10;      // more where the lumen is flat
constexpr double kFlat = 2.0;           // extent over radius
constexpr double kSettled = 0.02;       // of the extent: a line that moves less (rms) has settled
constexpr double kFinalStep = 0.25;     // of the radius
constexpr double kMostLastMove = 0.15;  // of the extent, when the numbers are taken

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

/// What a round of fitting did to each point of a line.
struct FitRound {
  std::vector<char> fitted;   ///< 1: the model saw enough wall
  std::vector<double> shift;  ///< how far the point was moved, in extents
};

/// Whether points [first, last) hardly moved any more, as a whole.
bool has_settled(const std::vector<double>& shift, std::size_t first, std::size_t last) {
  double squares = 0.0;
  for (std::size_t i = first; i < last; ++i) squares += shift[i] * shift[i];
  return squares <= kSettled * kSettled * double(last - first);
}

/// Moves each own point that is out of the parent's lumen to the middle of the tube fitted to the
/// wall round it, and takes its radius (and, when measuring, its area) from there.
/// @param only  where it is not empty: the points to look at
FitRound fit_points(Line& work, const Line* parent, const Wall& wall, const WallPoints& points,
                    TubeEffort effort, const std::vector<char>& only = {}) {
  Polyline& line = work.line;
  const std::vector<double> s = arc_length(line.points);
  const std::size_t first = std::max(work.shared, first_outside(work, parent));
  std::vector<TubeSection> sections(line.points.size());
  if (effort == TubeEffort::measure)
    sections = measure_tube(points, line, first, line.points.size(), &wall);
  else
    parallel_for_uneven(std::ptrdiff_t(line.points.size() - first), [&](std::ptrdiff_t index) {
      const std::size_t i = first + std::size_t(index);
      if (!only.empty() && only[i] == 0) return;
      const LocalCurve curve =
          fit_curve(line, s, i, course_reach(effort) * direction_reach(line, i));
      sections[i] = fit_tube(points, curve, line.radius[i], line.extent[i], &wall, effort);
    });
  FitRound round;
  round.fitted.assign(line.points.size(), 0);
  round.shift.assign(line.points.size(), 0.0);
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
      round.shift[i] = distance(sections[i].center, line.points[i]) / sections[i].extent;
      line.points[i] = sections[i].center;
    }
    line.radius[i] = sections[i].inscribed_radius;
    line.extent[i] = sections[i].extent;
    if (effort == TubeEffort::measure) work.area[i] = sections[i].area;
  }
  return round;
}

/// The flat stretches of a line that have not settled, and a little beside them.
std::vector<char> unsettled_flats(const Polyline& line, const std::vector<double>& shift) {
  constexpr std::size_t kBeside = 2;  // as far as smoothing draws on
  const std::size_t count = line.points.size();
  const auto is_flat = [&](std::size_t i) { return line.extent[i] > kFlat * line.radius[i]; };
  std::vector<char> marked(count, 0);
  for (std::size_t begin = 0; begin < count; ++begin) {
    if (!is_flat(begin)) continue;
    std::size_t end = begin;
    while (end < count && is_flat(end)) ++end;
    if (!has_settled(shift, begin, end))
      std::fill(marked.begin() + std::ptrdiff_t(begin - std::min(begin, kBeside)),
                marked.begin() + std::ptrdiff_t(std::min(end + kBeside, count)), 1);
    begin = end;
  }
  return marked;
}

/// Where the lumen is flat each round goes some way along it only, so it takes more of them.
void settle_flats(Line& work, const Line* parent, const Wall& wall, const WallPoints& points,
                  std::vector<double> shift) {
  for (int round = 0; round < kFlatFitRounds; ++round) {
    const std::vector<char> only = unsettled_flats(work.line, shift);
    if (std::find(only.begin(), only.end(), 1) == only.end()) return;
    const Polyline before = work.line;
    smooth(work.line, work.shared, 2);
    for (std::size_t i = 0; i < only.size(); ++i)
      if (only[i] == 0) work.line.points[i] = before.points[i];
    shift = fit_points(work, parent, wall, points, TubeEffort::center, only).shift;
  }
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
  std::vector<double> shift;
  for (int round = 1; round <= kFitRounds; ++round) {
    resample(work.line, work.shared, work_step);
    smooth(work.line, work.shared, 2);  // against hooks at mouths; the fit centres again
    shift = fit_points(work, parent, wall, points, TubeEffort::center).shift;
    if (round > 1 && has_settled(shift, first_outside(work, parent), shift.size())) break;
  }
  settle_flats(work, parent, wall, points, std::move(shift));
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
    Line work = parent == nullptr ? start_line(lumen, skeleton, wall)
                                  : start_branch(lumen, plan, *parent, wall);
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

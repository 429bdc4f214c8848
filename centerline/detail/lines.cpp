#include "centerline/detail/lines.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

#include "centerline/detail/line_shape.hpp"
#include "centerline/detail/line_starts.hpp"
#include "centerline/detail/line_tips.hpp"
#include "centerline/detail/point_row.hpp"
#include "centerline/detail/polyline.hpp"
#include "centerline/detail/ridge.hpp"
#include "centerline/detail/section.hpp"
#include "centerline/detail/smooth_curve.hpp"
#include "centerline/detail/tube_model.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

constexpr int kRounds = 4;             // of centring by rays
constexpr int kFitRounds = 5;          // of centring by the tube model, at most
constexpr int kFlatFitRounds = 10;     // more where the lumen is flat
constexpr double kFlat = 2.0;          // extent over radius
constexpr double kSettled = 0.02;      // of the extent: a line that moves less (rms) has settled
constexpr double kMostLastMove = 0.3;  // of the extent, when the numbers are taken
constexpr double kUnseen = 0.05;       // weight of a place where no section was seen
/// How stiff the line is, in radii, while it is moved by rays, by the tube model, and at last.
constexpr double kRayStiffness = 0.6, kTubeStiffness = 0.4, kLastStiffness = 0.3;

/// What a look at the wall says of each point of a line, and how wide the vessel is there.
struct Look {
  Middles middles;
  std::vector<char> seen;      ///< 1: the section was seen
  std::vector<double> radius;  ///< inscribed, of the section that was seen [mm]
};

/// Before anything was seen. In its parent's lumen a branch has no section of its own: there the
/// voxels that it was traced along show the way through the middle of its mouth.
/// @param first  the first own point that is out of the parent's lumen
Look blank_look(const Line& work, std::size_t first) {
  constexpr double kMouth = 0.3;  // weight
  const Polyline& line = work.line;
  const std::size_t count = line.points.size();
  Look look{
      {line.points, std::vector<double>(count, kUnseen)}, std::vector<char>(count, 0), line.radius};
  for (std::size_t i = work.shared; i < std::min(first + 1, count); ++i) {
    look.middles.center[i] = work.course[work.course.nearest(line.points[i])];
    look.middles.weight[i] = kMouth;
  }
  return look;
}

/// Looks for the centre of each own point's section that is out of the parent's lumen, by rays.
Look look_by_rays(Line& work, const Line* parent, const Surroundings& around) {
  const Wall& wall = around.wall;
  Polyline& line = work.line;
  const std::vector<double> s = arc_length(line.points);
  const std::size_t first = std::max(work.shared, first_outside(work, parent));
  Look look = blank_look(work, first);
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
    look.seen[i] = 1;
    look.middles.center[i] = line.points[i] + 0.8 * (section.center - line.points[i]);
    look.middles.weight[i] = 1.0;
    radius[i] = section.inscribed_radius;
    extent[i] = section.extent;
  });
  line.radius = std::move(radius);
  line.extent = std::move(extent);
  return look;
}

/// Whether points [first, last) hardly moved any more, as a whole.
bool has_settled(const std::vector<double>& shift, std::size_t first, std::size_t last) {
  double squares = 0.0;
  for (std::size_t i = first; i < last; ++i) squares += shift[i] * shift[i];
  return squares <= kSettled * kSettled * double(last - first);
}

/// Fits a tube to the wall round each own point that is out of the parent's lumen, and takes its
/// radius (and, when measuring, its area) from there.
/// @param only  where it is not empty: the points to look at
Look look_by_tubes(Line& work, const Line* parent, const Surroundings& around, TubeEffort effort,
                   const std::vector<char>& only = {}) {
  Polyline& line = work.line;
  const std::vector<double> s = arc_length(line.points);
  const std::size_t first = std::max(work.shared, first_outside(work, parent));
  std::vector<TubeSection> sections(line.points.size());
  if (effort == TubeEffort::measure)
    sections = measure_tube(around.points, line, first, line.points.size(), &around.wall);
  else
    parallel_for_uneven(std::ptrdiff_t(line.points.size() - first), [&](std::ptrdiff_t index) {
      const std::size_t i = first + std::size_t(index);
      if (!only.empty() && only[i] == 0) return;
      const LocalCurve curve =
          fit_curve(line, s, i, course_reach(effort) * direction_reach(line, i));
      sections[i] =
          fit_tube(around.points, curve, line.radius[i], line.extent[i], &around.wall, effort);
    });
  Look look = blank_look(work, first);
  for (std::size_t i = 0; i < only.size(); ++i)
    if (only[i] == 0) look.middles.weight[i] = 1.0;  // stays as it is
  for (std::size_t i = first; i < line.points.size(); ++i) {
    const bool in_cap = s[i] < work.start_cap || s.back() - s[i] < work.end_cap;
    if (in_cap) look.middles.weight[i] = 1.0;  // stays on the vessel's axis
    if (!sections[i].valid) continue;
    // A settled line moves little: what still jumps saw another wall.
    if (effort == TubeEffort::measure &&
        distance(sections[i].center, line.points[i]) > kMostLastMove * sections[i].extent)
      continue;
    look.seen[i] = 1;
    look.radius[i] = sections[i].inscribed_radius;
    // While a line moves, its tips are left alone, so that they cannot creep along the cap.
    const double zone = effort == TubeEffort::measure ? 0.0 : kEndZone * line.radius[i];
    if (!in_cap && !(work.free_start && s[i] < zone) &&
        !(work.free_end && s.back() - s[i] < zone)) {
      look.middles.center[i] = sections[i].center;
      look.middles.weight[i] = 1.0;
    }
    line.radius[i] = sections[i].inscribed_radius;
    line.extent[i] = sections[i].extent;
    if (effort == TubeEffort::measure) work.area[i] = sections[i].area;
  }
  return look;
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

/// One round of centring by the tube model. @return how far each point moved, in extents
std::vector<double> center_by_tubes(Line& work, const Line* parent, const Surroundings& around,
                                    const std::vector<char>& only = {}) {
  const std::vector<Vec3> before = work.line.points;
  Look look = look_by_tubes(work, parent, around, TubeEffort::center, only);
  settle(work, around, std::move(look.middles), kTubeStiffness);
  std::vector<double> shift(before.size());
  for (std::size_t i = 0; i < before.size(); ++i)
    shift[i] = distance(before[i], work.line.points[i]) / work.line.extent[i];
  return shift;
}

/// Moves a line to the middle, in rounds, its points spread anew for each.
void center(Line& work, const Line* parent, const Surroundings& around,
            const std::function<double(double)>& step) {
  const auto spread = [&] {
    check_widths(work, around.distance_to_wall);
    resample(work.line, work.shared, step);
    smooth_widths(work.line, work.shared, 2);
  };
  for (int round = 0; round < kRounds; ++round) {
    spread();
    Look look = round == 0 ? blank_look(work, work.shared) : look_by_rays(work, parent, around);
    settle(work, around, std::move(look.middles), kRayStiffness);
  }
  std::vector<double> shift;
  for (int round = 1; round <= kFitRounds; ++round) {
    spread();
    shift = center_by_tubes(work, parent, around);
    if (round > 1 && has_settled(shift, first_outside(work, parent), shift.size())) break;
  }
  // Where the lumen is flat each round goes some way along it only, so it takes more of them.
  for (int round = 0; round < kFlatFitRounds; ++round) {
    const std::vector<char> only = unsettled_flats(work.line, shift);
    if (std::find(only.begin(), only.end(), 1) == only.end()) break;
    shift = center_by_tubes(work, parent, around, only);
  }
}

/// The numbers that are kept: by the tube model; where it sees too little wall (in branchings, at
/// ragged ends) areas are by rays.
/// @return what the tube model saw
Look measure(Line& work, const Line* parent, const Surroundings& around) {
  work.area.resize(work.shared);
  work.area.resize(work.line.points.size(), 0.0);
  Look look = look_by_tubes(work, parent, around, TubeEffort::measure);
  const Wall& wall = around.wall;
  const Polyline& line = work.line;
  const std::vector<double> s = arc_length(line.points);
  parallel_for_uneven(std::ptrdiff_t(line.points.size() - work.shared), [&](std::ptrdiff_t index) {
    const std::size_t i = work.shared + std::size_t(index);
    if (look.seen[i] != 0) return;
    SectionOptions options;
    options.ray_count = 64;
    options.expected = std::max(line.radius[i], wall.resolution());
    const Section section = measure_section(
        wall, line.points[i], tangent_at(line, s, i, direction_reach(line, i)), options);
    // From beside the middle, the wall that is near says nothing of the vessel's width.
    if (section.valid && distance(section.center, line.points[i]) < 0.5 * section.inscribed_radius)
      work.area[i] = section.area;
  });
  return look;
}

/// The radius of the vessel around each point [mm]: by the line's own radii, and where it runs off
/// the middle for longer than those tell, by the median of its sections within four radii of the
/// point's (a sac's do not make the vessel beside it wide).
std::vector<double> width_around(const Line& work, const std::vector<double>& s) {
  constexpr double kReach = 4.0;
  std::vector<double> around = radius_around(work.line, s);
  std::vector<double> near;
  for (std::size_t i = work.shared; i < around.size(); ++i) {
    const double reach = kReach * std::max(work.fitted[i], work.line.radius[i]);
    const auto own = s.begin() + std::ptrdiff_t(work.shared);
    const auto first = std::lower_bound(own, s.end(), s[i] - reach) - s.begin(),
               last = std::upper_bound(s.begin(), s.end(), s[i] + reach) - s.begin();
    near.assign(work.fitted.begin() + first, work.fitted.begin() + last);
    around[i] = std::max(around[i], quantile(near, 0.5));
  }
  return around;
}

/// The place on the line through a row of points that is nearest to a place.
Vec3 beside_on(const PointRow& row, const Vec3& place) {
  const std::size_t nearest = row.nearest(place);
  Vec3 best = row[nearest];
  for (const std::size_t other :
       {nearest - std::min<std::size_t>(nearest, 1), std::min(nearest + 1, row.size() - 1)}) {
    const Vec3 along = row[other] - row[nearest];
    const double squared = norm_squared(along);
    if (!(squared > 0.0)) continue;
    const double t = std::clamp(dot(place - row[nearest], along) / squared, 0.0, 1.0);
    const Vec3 there = row[nearest] + t * along;
    if (norm_squared(there - place) < norm_squared(best - place)) best = there;
  }
  return best;
}

/// How wide the lumen is beside each point of a line that runs off the middle there: the greatest
/// ball with its middle in the point's section, between which and the point the lumen only gets
/// wider, or that of the nearest middle. 0 where the line is in the middle, or at a closed tip,
/// where the nearest wall is the cap.
/// @param middles  of the vessel, before its line was straightened
std::vector<double> radius_beside(const Line& work, const PointRow& middles,
                                  const Surroundings& surroundings) {
  constexpr double kNear = 0.9, kTip = 2.0, kOpen = 0.5;
  const Polyline& line = work.line;
  const std::vector<double> s = arc_length(line.points), around = width_around(work, s);
  const auto is_closed = [&](std::size_t tip) { return line.radius[tip] < kOpen * around[tip]; };
  const bool closed_start = work.free_start && is_closed(0),
             closed_end = work.free_end && is_closed(line.points.size() - 1);
  std::vector<double> beside(line.points.size(), 0.0);
  parallel_for_uneven(std::ptrdiff_t(line.points.size() - work.shared), [&](std::ptrdiff_t index) {
    const std::size_t i = work.shared + std::size_t(index);
    const double zone = kTip * around[i];
    if ((closed_start && s[i] < zone) || (closed_end && s.back() - s[i] < zone)) return;
    const double of_middle =
        surroundings.distance_to_wall.at(beside_on(middles, line.points[i]), line.radius[i]);
    if (line.radius[i] >= kNear * std::max(around[i], of_middle)) return;
    const Vec3 deepest =
        deepest_in_section(line.points[i], tangent_at(line, s, i, direction_reach(line, i)),
                           around[i], surroundings.distance_to_wall, surroundings.wall);
    beside[i] = std::max(surroundings.distance_to_wall.at(deepest, line.radius[i]), of_middle);
  });
  return beside;
}

/// The radius at each point is the distance to the wall there: the model's, which the wall's noise
/// and its flat triangles do not make too low, as long as it is within 1 % of the wall itself. The
/// tube's is the model's, or that of the greatest ball beside the line where that is wider: a line
/// that cuts a bend's corner is no stenosis.
void take_radii(Line& work, const Look& look, const PointRow& middles, const Surroundings& around) {
  constexpr double kMost = 1.01;
  Polyline& line = work.line;
  work.seen.resize(line.points.size(), 0);
  work.fitted.resize(line.points.size(), 0.0);
  parallel_for_uneven(std::ptrdiff_t(line.points.size() - work.shared), [&](std::ptrdiff_t index) {
    const std::size_t i = work.shared + std::size_t(index);
    const double here = around.distance_to_wall.at(line.points[i], line.radius[i]);
    work.seen[i] = look.seen[i];
    line.radius[i] = look.seen[i] != 0 ? std::clamp(look.radius[i], here, kMost * here) : here;
    work.fitted[i] = look.seen[i] != 0 ? look.radius[i] : here;
  });
  const std::vector<double> beside = radius_beside(work, middles, around);
  for (std::size_t i = work.shared; i < line.points.size(); ++i) {
    work.fitted[i] = std::max(work.fitted[i], beside[i]);
    const double widest = std::max(line.radius[i], beside[i]);
    work.area[i] = std::max(work.area[i], units::kPi * widest * widest);
  }
}

/// Settles a line whose sections were measured. A middle that leads much nearer to the wall is
/// none: the section held more than this vessel.
void settle_last(Line& work, const Surroundings& around, Middles middles) {
  constexpr int kMostRounds = 4;
  constexpr double kNearer = 0.8;
  const std::vector<Vec3> before = work.line.points;
  const auto distances = [&] {
    std::vector<double> result(before.size());
    parallel_for_uneven(std::ptrdiff_t(before.size()), [&](std::ptrdiff_t index) {
      const auto i = std::size_t(index);
      result[i] = around.distance_to_wall.at(work.line.points[i], work.line.radius[i]);
    });
    return result;
  };
  const std::vector<double> distance_before = distances();
  for (int round = 0; round < kMostRounds; ++round) {
    work.line.points = before;
    settle(work, around, middles, kLastStiffness);
    const std::vector<double> distance_now = distances();
    bool is_fine = true;
    for (std::size_t i = work.shared; i < before.size(); ++i) {
      if (distance_now[i] >= kNearer * distance_before[i]) continue;
      is_fine = false;
      middles.center[i] = before[i];
      middles.weight[i] = round + 1.0;
    }
    if (is_fine) return;
  }
}

/// Whether the own points of a line are neither crowded nor far apart.
bool is_even(const Line& work, const std::function<double(double)>& step) {
  const Polyline& line = work.line;
  for (std::size_t i = work.shared; i + 1 < line.points.size(); ++i) {
    const double part = distance(line.points[i], line.points[i + 1]) / step(line.radius[i]);
    if (part < 0.3 || part > 3.0) return false;
  }
  return true;
}

/// The line in the middle, smooth, with the numbers that are kept.
void finish(Line& work, const Line* parent, const Surroundings& around) {
  constexpr int kMostClimbs = 3;
  const PointRow middles(work.line.points);
  const auto spread = [&] {
    check_widths(work, around.distance_to_wall);
    straighten(work, parent, around, around.last_step);
    resample(work.line, work.shared, around.last_step);
  };
  spread();
  for (int climb = 0; climb < kMostClimbs && climb_to_ridge(work, around, kLastStiffness); ++climb)
    spread();
  Look look = measure(work, parent, around);
  settle_last(work, around, look.middles);
  check_widths(work, around.distance_to_wall);
  if (!is_even(work, around.last_step) || has_turns(work, parent)) {
    spread();
    look = measure(work, parent, around);
  }
  take_radii(work, look, middles, around);
}

CenterlinePath to_path(const Line& line, int id) {
  CenterlinePath path;
  path.id = id;
  path.points = line.line.points;
  path.inscribed_radius = line.line.radius;
  path.tube_radius = line.fitted;
  path.section_area = line.area;
  path.abscissa = arc_length(path.points);
  for (const double area : path.section_area)
    path.equivalent_radius.push_back(std::sqrt(area / units::kPi));
  return path;
}

/// Where the data end within the inscribed ball.
std::vector<char> find_cut(const CenterlinePath& path, const Wall& wall) {
  std::vector<char> is_cut;
  for (std::size_t i = 0; i < path.points.size(); ++i)
    is_cut.push_back(char(wall.depth_in_data(path.points[i]) < path.inscribed_radius[i]));
  return is_cut;
}

}  // namespace

TracedLines trace_lines(const Skeleton& skeleton, const Surroundings& around,
                        const Progress& progress) {
  const std::vector<Plan> plans = plan_lines(around.lumen, skeleton);
  std::vector<Line> lines(plans.size());
  const auto trace_line = [&](std::size_t index) {
    const Plan& plan = plans[index];
    const Line* parent = plan.parent >= 0 ? &lines[std::size_t(plan.parent)] : nullptr;
    Line work = parent == nullptr ? start_line(around.lumen, skeleton, around.wall)
                                  : start_branch(around.lumen, plan, *parent, around.wall);
    center(work, parent, around,
           [&](double r) { return std::max(kWorkStep * r, 0.4 * around.wall.resolution()); });
    redo_ends(work, around);
    finish(work, parent, around);
    stay_in_lumen(work, around.wall);
    if (parent != nullptr) take_skipped(work, *parent);
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
    progress.report(double(done) / double(plans.size()), "centring lines");
  }
  std::stable_sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) {
    return arc_length(a.line.points).back() > arc_length(b.line.points).back();
  });
  TracedLines result;
  for (Line& line : lines) {
    result.tree.paths.push_back(to_path(line, int(result.tree.paths.size())));
    result.is_tube.push_back(std::move(line.seen));
    result.is_cut.push_back(find_cut(result.tree.paths.back(), around.wall));
  }
  return result;
}

}  // namespace angio::centerline

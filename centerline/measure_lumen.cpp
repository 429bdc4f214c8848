#include <algorithm>
#include <utility>

#include "centerline/centerline.hpp"
#include "centerline/detail/polyline.hpp"
#include "centerline/detail/surface_wall.hpp"
#include "centerline/detail/tube_model.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"

namespace angio::centerline {

namespace {

/// Points [first, last) of a line.
struct Range {
  std::size_t first = 0, last = 0;
};

Range range_between(const CenterlinePath& path, double first_abscissa, double last_abscissa) {
  const auto begin = std::lower_bound(path.abscissa.begin(), path.abscissa.end(), first_abscissa);
  const auto end = std::upper_bound(begin, path.abscissa.end(), last_abscissa);
  return {std::size_t(begin - path.abscissa.begin()), std::size_t(end - path.abscissa.begin())};
}

/// With the points to both sides whose directions count for those at the ends.
Range widened(const CenterlinePath& path, Range range) {
  constexpr double kMargin = 4.0;  // radii
  const double first = path.abscissa[range.first] - kMargin * path.equivalent_radius[range.first];
  const double last =
      path.abscissa[range.last - 1] + kMargin * path.equivalent_radius[range.last - 1];
  while (range.first > 0 && path.abscissa[range.first - 1] >= first) --range.first;
  while (range.last < path.points.size() && path.abscissa[range.last] <= last) ++range.last;
  return range;
}

/// The wall's distance at a point of a line, which may have moved outward to several times the
/// path's radius there; in a throat that has been opened to the width of the widest place or
/// beyond.
/// @return 0: there is none around
double find_wall(const WallPoints& points, const LocalCurve& curve, double radius, double widest) {
  constexpr double kMostGrowth = 4.0, kMostOfWidest = 2.0;
  double found = 0.0;
  for (double most = kMostGrowth * radius; radius > 0.0 && !(found > 0.0); most *= 2.0) {
    found = look_for_wall(points, curve, most);
    if (most >= kMostOfWidest * widest) break;
  }
  return found;
}

/// Sections at some points of a line, whose widths are known from elsewhere or not yet.
std::vector<TubeSection> fit_sections(const WallPoints& points, const Polyline& line, Range stretch,
                                      bool look) {
  const std::vector<double> s = arc_length(line.points);
  double widest = 0.0;
  for (std::size_t i = stretch.first; i < stretch.last; ++i)
    widest = std::max({widest, line.radius[i], line.extent[i]});
  std::vector<TubeSection> sections(line.points.size());
  parallel_for_uneven(std::ptrdiff_t(stretch.last - stretch.first), [&](std::ptrdiff_t index) {
    const std::size_t i = stretch.first + std::size_t(index);
    const LocalCurve curve =
        fit_curve(line, s, i, course_reach(TubeEffort::center) * direction_reach(line, i));
    double radius = line.radius[i], extent = line.extent[i];
    if (look) {
      radius = find_wall(points, curve, radius, widest);
      extent = std::max(extent, radius);
    }
    if (radius > 0.0)
      sections[i] = fit_tube(points, curve, radius, extent, nullptr, TubeEffort::center);
  });
  return sections;
}

void take_over(const std::vector<TubeSection>& sections, Range stretch, Polyline& line) {
  for (std::size_t i = stretch.first; i < stretch.last; ++i) {
    if (!sections[i].valid) continue;
    line.points[i] = sections[i].center;
    line.radius[i] = sections[i].inscribed_radius;
    line.extent[i] = sections[i].extent;
  }
}

/// The line in the middle of the wall as it is now. @param line  found before the wall moved
Polyline center_again(const WallPoints& points, Polyline line, Range stretch) {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    take_over(fit_sections(points, line, stretch, round == 0), stretch, line);
    smooth(line, 0, 2);
  }
  return line;
}

/// The line in the middle of its sections. Its points beyond them are left: smoothing them moment
/// after moment would straighten them.
void center_by(const std::vector<TubeSection>& sections, Range stretch, Polyline& line) {
  take_over(sections, stretch, line);
  Polyline smoothed = line;
  smooth(smoothed, 0, 2);
  for (std::size_t i = stretch.first; i < stretch.last; ++i) {
    line.points[i] = smoothed.points[i];
    line.radius[i] = smoothed.radius[i];
    line.extent[i] = smoothed.extent[i];
  }
}

/// Takes a line along with the path that it was found from: each point stays beside its own. What
/// smoothing has shifted along the line would grow from moment to moment, and is taken back.
void move_along(const CenterlinePath& path, const std::vector<Vec3>& before, Polyline& line) {
  const std::size_t last = line.points.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    const Vec3 along =
        normalized(before[std::min(i + 1, last)] - before[std::max<std::size_t>(i, 1) - 1]);
    const Vec3 aside = line.points[i] - before[i];
    line.points[i] = path.points[i] + aside - dot(aside, along) * along;
  }
}

std::ptrdiff_t count_valid(const std::vector<TubeSection>& sections) {
  return std::count_if(sections.begin(), sections.end(),
                       [](const TubeSection& section) { return section.valid; });
}

}  // namespace

LumenProfile without_disproved(const LumenProfile& seen) {
  const auto& [s, radius, area] = seen;
  LumenProfile left;
  for (std::size_t i = 0; i < s.size(); ++i) {
    if (i > 0 && i + 1 < s.size() && radius[i] < radius[i - 1] - (s[i] - s[i - 1]) &&
        radius[i] < radius[i + 1] - (s[i + 1] - s[i]))
      continue;
    left.abscissa.push_back(s[i]);
    left.inscribed_radius.push_back(radius[i]);
    left.section_area.push_back(area[i]);
  }
  return left;
}

LumenProfile measure_lumen(const TriangleMesh& surface, const CenterlinePath& path,
                           double first_abscissa, double last_abscissa) {
  ClosedSurface closed = close_surface(surface);
  closed.mesh.vertices.resize(std::size_t(closed.wall_vertex_count));
  return measure_lumen(std::move(closed.mesh.vertices), path, first_abscissa, last_abscissa);
}

LumenProfile measure_lumen(std::vector<Vec3> wall, const CenterlinePath& path,
                           double first_abscissa, double last_abscissa) {
  return LumenFollower(first_abscissa, last_abscissa).measure(std::move(wall), path);
}

struct LumenFollower::Seen {
  std::vector<Vec3> path;  ///< as it was
  Polyline line;           ///< in the middle of the wall
  std::ptrdiff_t valid_count = 0;
};

LumenFollower::LumenFollower(double first_abscissa, double last_abscissa)
    : first_abscissa_(first_abscissa), last_abscissa_(last_abscissa) {}
LumenFollower::~LumenFollower() = default;
LumenFollower::LumenFollower(LumenFollower&&) noexcept = default;
LumenFollower& LumenFollower::operator=(LumenFollower&&) noexcept = default;

LumenProfile LumenFollower::measure(std::vector<Vec3> wall, const CenterlinePath& path) {
  if (path.points.size() < 2)
    throw InputError("the path has fewer than two points, so it has no sections. Run centerline");
  const WallPoints points(std::move(wall));
  const Range stretch = range_between(path, first_abscissa_, last_abscissa_);
  if (stretch.first >= stretch.last) return {};
  std::vector<TubeSection> sections;
  if (seen_ != nullptr) {
    move_along(path, seen_->path, seen_->line);
    sections = measure_tube(points, seen_->line, stretch.first, stretch.last, nullptr,
                            ScaleChoice::sparse);
    center_by(sections, stretch, seen_->line);
  }
  // What is lost from sight is looked for anew.
  if (seen_ == nullptr || count_valid(sections) < seen_->valid_count) {
    seen_ = std::make_unique<Seen>();
    seen_->line = center_again(points, {path.points, path.inscribed_radius, path.equivalent_radius},
                               widened(path, stretch));
    sections = measure_tube(points, seen_->line, stretch.first, stretch.last, nullptr);
  }
  seen_->path = path.points;
  seen_->valid_count = count_valid(sections);
  LumenProfile profile;
  for (std::size_t i = stretch.first; i < stretch.last; ++i) {
    if (!sections[i].valid) continue;  // the plane misses the lumen: at a rim
    profile.abscissa.push_back(path.abscissa[i]);
    profile.inscribed_radius.push_back(sections[i].inscribed_radius);
    profile.section_area.push_back(sections[i].area);
  }
  return profile;
}

Tightest tightest_between(const LumenProfile& profile, double first_abscissa,
                          double last_abscissa) {
  if (profile.abscissa.empty())
    throw InputError(
        "no section of the lumen was found along the balloon (the line runs outside the mesh). Run "
        "angio centerline and the stages behind it again");
  const auto away = [&](std::size_t i) {
    return std::max(
        {first_abscissa - profile.abscissa[i], profile.abscissa[i] - last_abscissa, 0.0});
  };
  double nearest = away(0);
  for (std::size_t i = 1; i < profile.abscissa.size(); ++i) nearest = std::min(nearest, away(i));
  Tightest least{1e9, 1e9, profile.abscissa.front()};
  for (std::size_t i = 0; i < profile.abscissa.size(); ++i) {
    if (away(i) > nearest) continue;
    least.mld_mm = std::min(least.mld_mm, 2.0 * profile.inscribed_radius[i]);
    if (profile.section_area[i] >= least.mla_mm2) continue;
    least.mla_mm2 = profile.section_area[i];
    least.mla_abscissa_mm = profile.abscissa[i];
  }
  return least;
}

}  // namespace angio::centerline

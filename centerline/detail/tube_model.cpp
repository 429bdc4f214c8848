#include "centerline/detail/tube_model.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "centerline/detail/contour.hpp"
#include "centerline/detail/tube_fit.hpp"
#include "core/centerline.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

constexpr int kContourPoints = 96;
constexpr double kCenterWindow = 0.9;
constexpr double kSteepest = 0.82;  // cosine: a wall steeper than 35 degrees is a mouth, no taper

/// The model's contour in the section's plane.
Contour contour_of(const Fit& fit, const Stretch& stretch) {
  Contour contour;
  for (int i = 0; i < kContourPoints; ++i) {
    Sample at;
    const double theta = 2.0 * units::kPi * i / kContourPoints;
    at.cos = std::cos(theta);
    at.sin = std::sin(theta);
    const double r = std::max(predict(fit, at), 0.0);
    contour.push_back(stretch.undo({r * at.cos, r * at.sin}));
  }
  return contour;
}

/// Whether a section is no flatter than noise makes a round one: with half axes r l and r / l the
/// second harmonic is r (l - 1 / l) / 2.
bool is_noise(const Stretch& stretch, const Fit& fit) {
  const double squeeze = std::hypot(0.5 * (stretch.xx - stretch.yy), stretch.xy);
  const double cosine = fit.error[first_term(2, false)], sine = fit.error[first_term(2, true)];
  const double flat = fit.terms[0] * squeeze;
  return squeeze > 0.0 && flat * flat < kSignificant * (cosine * cosine + sine * sine);
}

/// Takes off what the noise of vertices adds. @return the part of each radius that is kept
std::vector<double> take_off_bias(Contour& contour, double sd) {
  std::vector<double> keep = polar_bias(contour, sd);
  for (std::size_t i = 0; i < contour.size(); ++i) {
    const double r = std::hypot(contour[i].x, contour[i].y);
    keep[i] = r > 0.0 ? 1.0 - keep[i] / r : 1.0;
    contour[i] = {keep[i] * contour[i].x, keep[i] * contour[i].y};
  }
  return keep;
}

/// Standard error of the contour, the mean all round [mm].
double contour_error(const Fit& fit) {
  double squares = fit.error[0] * fit.error[0];
  for (int m = 1; m <= fit.order; ++m)
    for (const bool sine : {false, true}) {
      const double error = fit.error[first_term(m, sine)];
      squares += 0.5 * error * error;
    }
  return std::sqrt(squares);
}

/// The least value of a smooth function given at even steps: a parabola through the lowest three.
double lowest(const std::vector<double>& values) {
  const auto at = std::min_element(values.begin(), values.end());
  if (at == values.begin() || at + 1 == values.end()) return *at;
  const double before = *(at - 1), after = *(at + 1);
  const double bend = before - 2.0 * *at + after, slope = 0.5 * (after - before);
  return bend > 0.0 ? std::max(*at - 0.5 * slope * slope / bend, 0.5 * *at) : *at;
}

/// How far along the line wall points are gathered, in radii.
double reach_of(TubeEffort effort, const TubeScale& scale) {
  switch (effort) {
    case TubeEffort::center:
      return kCenterWindow;
    case TubeEffort::measure:
      return kWindows[std::size(kWindows) - 1];
    case TubeEffort::follow:
      return std::max(kCenterWindow, scale.window);
  }
  return kCenterWindow;
}

/// The model's wall round a section, in space: where the vessel tapers, the wall that is nearest to
/// a place of the section is not in the section. All lengths in mm.
class WallAround {
 public:
  /// @param keep  parts of the radii in each direction
  WallAround(const Fit& fit, const Stretch& stretch, const LocalCurve& curve,
             const std::vector<double>& keep) {
    const Vec3 tangent = cross(curve.u, curve.v);
    for (int i = 0; i < kContourPoints; i += 2) {
      Sample at;
      const double theta = 2.0 * units::kPi * i / kContourPoints;
      at.cos = std::cos(theta);
      at.sin = std::sin(theta);
      rows_.push_back(points_.size());
      for (int k = -kSteps; k <= kSteps; ++k) {
        at.s = 0.7 * fit.window * k / kSteps;
        if (at.s < curve.first || at.s > curve.last) continue;
        const Vec3 t = curve.tangent(at.s);
        const Vec3 u = normalized(curve.u - dot(curve.u, t) * t);
        const double r = std::max(predict(fit, at), 0.0) * keep[std::size_t(i)];
        const Point2 p = stretch.undo({r * at.cos, r * at.sin});
        const Vec3 d = curve.at(at.s) + p.x * u + p.y * cross(t, u) - curve.origin;
        points_.push_back({dot(d, curve.u), dot(d, curve.v), dot(d, tangent)});
      }
    }
    rows_.push_back(points_.size());
  }

  /// The radius of the largest ball with its centre in the section, near a place: the largest
  /// circle's centre, but where the wall leans more on one side than on the other.
  [[nodiscard]] double largest_ball(Point2 center, double most_shift) const {
    constexpr double kFirstStep = 0.1, kLastStep = 1e-3;  // of the radius
    const Point2 start = center;
    Clearance here = clearance(center);
    for (double step = kFirstStep * here.radius; step > kLastStep * here.radius;) {
      const Point2 way = away_from_near(here, step),
                   trial{center.x + step * way.x, center.y + step * way.y};
      Clearance there = clearance(trial);
      if (there.radius > here.radius &&
          std::hypot(trial.x - start.x, trial.y - start.y) <= most_shift) {
        center = trial;
        here = std::move(there);
      } else {
        step *= 0.5;
      }
    }
    return here.radius;
  }

 private:
  static constexpr int kSteps = 4;  // to each side

  /// How far away the wall is in each direction, and which way leads off it.
  struct Clearance {
    double radius = 1e300;  ///< the least distance [mm]
    std::vector<double> distance;
    std::vector<Point2> off;  ///< the distance's slope
  };
  [[nodiscard]] Clearance clearance(const Point2& place) const {
    Clearance around;
    std::vector<double> squared;
    for (std::size_t row = 0; row + 1 < rows_.size(); ++row) {
      squared.clear();
      for (std::size_t n = rows_[row]; n < rows_[row + 1]; ++n)
        squared.push_back(norm_squared(points_[n] - Vec3{place.x, place.y, 0.0}));
      const double d = std::sqrt(lowest(squared));
      const auto nearest = std::min_element(squared.begin(), squared.end()) - squared.begin();
      const Vec3& wall = points_[rows_[row] + std::size_t(nearest)];
      around.distance.push_back(d);
      around.off.push_back({(place.x - wall.x) / d, (place.y - wall.y) / d});
      around.radius = std::min(around.radius, d);
    }
    return around;
  }
  /// The way off all wall that is nearly as near as the nearest, by exp(-4 distance / step): along
  /// a ridge of the distance, not across.
  [[nodiscard]] static Point2 away_from_near(const Clearance& around, double step) {
    Point2 way;
    for (std::size_t row = 0; row < around.off.size(); ++row) {
      const double weight = std::exp((around.radius - around.distance[row]) / (0.25 * step));
      way.x += weight * around.off[row].x;
      way.y += weight * around.off[row].y;
    }
    const double length = std::hypot(way.x, way.y);
    return length > 0.0 ? Point2{way.x / length, way.y / length} : Point2{};
  }

  std::vector<Vec3> points_;       ///< along u, v and the tangent; row by row
  std::vector<std::size_t> rows_;  ///< where each direction's points begin
};

}  // namespace

double look_for_wall(const WallPoints& points, const LocalCurve& curve, double widest) {
  for (double reach = 0.25 * widest; reach <= widest; reach *= 2.0) {
    const Coarse coarse = look_round(gather(points, curve, reach, reach, widest), reach);
    if (coarse.gap <= kSectors / 2) return coarse.typical;
  }
  return 0.0;
}

TubeSection fit_tube(const WallPoints& points, const LocalCurve& curve, double radius,
                     double extent, const Wall* wall, TubeEffort effort, TubeScale scale) {
  TubeSection section;
  section.center = curve.origin;
  const bool measure = effort != TubeEffort::center;
  const double reach = reach_of(effort, scale) * radius;
  std::vector<Sample> samples;
  Coarse coarse;
  // Beyond three radii there are other vessels; but so are the ends of a slit.
  for (const double widest : {3.0 * radius, 1.5 * extent}) {
    samples = gather(points, curve, radius, reach, widest);
    if (wall != nullptr && measure) keep_visible(samples, curve, *wall);
    coarse = look_round(samples, kCenterWindow * radius);
    if (extent <= 2.0 * radius || !is_open_to_both_sides(coarse)) break;
  }
  if (coarse.gap > kSectors / 2) return section;  // less than half of the wall
  keep_first_wall(samples, coarse);
  // Harmonics finer than the widest gap are not seen.
  const int most_order = std::clamp(kSectors / (2 * std::max(coarse.gap, 1)), 1, kMostOrder);
  const WallErrors errors{points.correlation_length(), scale.least_noise};
  Stretch stretch = find_stretch(coarse);
  for (Sample& sample : samples) set_polar(sample, stretch);
  Fit fit = fit_window(samples, kCenterWindow * radius, std::min(2, most_order), 3, errors, radius);
  if (!fit.valid) fit = fit_window(samples, reach, std::min(1, most_order), 3, errors, radius);
  if (!fit.valid) return section;
  if (fit.order >= 2) {
    if (scale.window > 0.0) {
      fit = fit_window(samples, scale.window * radius, std::min(scale.order, most_order), 2, errors,
                       radius);
    } else {
      if (measure) fit = choose_window(samples, radius, errors);
      if (fit.valid)
        fit = choose_order(samples, std::move(fit), measure ? most_order : std::min(4, most_order),
                           errors, radius);
    }
    if (!fit.valid) return section;
    if (errors.least_sd > 0.0 && fit.order >= 2 && is_noise(stretch, fit)) {
      stretch = {};
      for (Sample& sample : samples) set_polar(sample, stretch);
      fit = fit_window(samples, fit.window, fit.order, 2, errors, radius);
      if (!fit.valid) return section;
    }
  }
  shrink_harmonics(fit);
  Contour contour = contour_of(fit, stretch);
  std::vector<double> keep(contour.size(), 1.0);
  // Of level sets the errors go together. Both deviations hold some of the wall's shape too.
  if (errors.correlation <= 0.0) keep = take_off_bias(contour, std::min(coarse.noise, fit.noise));
  const double most_shift = 0.5 * std::max(radius, 0.5 * extent);
  const Circle circle = largest_circle(contour, most_shift);
  if (circle.radius <= 0.0) return section;
  const Point2 middle =
      section_middle(contour, circle, most_shift,
                     std::min(kConfidence * contour_error(fit), 0.05 * circle.radius));
  const double step = 2.0 * units::kPi / kContourPoints;
  section.center += middle.x * curve.u + middle.y * curve.v;
  section.inscribed_radius = circle.radius;
  if (measure)
    section.inscribed_radius =
        std::clamp(WallAround(fit, stretch, curve, keep).largest_ball(circle.center, most_shift),
                   kSteepest * circle.radius, circle.radius);
  section.area = contour_moments(contour).area * step / std::sin(step);
  section.extent = contour_extent(contour, middle);
  section.noise = fit.sd;
  section.scale = {fit.window / radius, fit.order};
  section.valid = true;
  return section;
}

namespace {

/// For each point the valid sections within its reach [mm], its own too, if there are any.
template <class Reach, class Use>
void for_each_neighbourhood(const std::vector<TubeSection>& sections, const std::vector<double>& s,
                            const Reach& reach_of, const Use& use) {
  std::vector<const TubeSection*> near;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const double reach = reach_of(i);
    std::size_t begin = i, end = i + 1;
    while (begin > 0 && s[i] - s[begin - 1] < reach) --begin;
    while (end < sections.size() && s[end] - s[i] < reach) ++end;
    near.clear();
    for (std::size_t k = begin; k < end; ++k)
      if (sections[k].valid) near.push_back(&sections[k]);
    if (!near.empty()) use(i, near);
  }
}

template <class Value>
double median_of(const std::vector<const TubeSection*>& sections, const Value& value) {
  std::vector<double> values;
  for (const TubeSection* section : sections) values.push_back(value(*section));
  return quantile(values, 0.5);
}

/// The middle of what the points near each one chose.
std::vector<TubeScale> settle_scales(const std::vector<TubeSection>& sections, const Polyline& line,
                                     const std::vector<double>& s) {
  constexpr double kNear = 2.0;  // radii
  std::vector<TubeScale> scales(sections.size());
  const auto reach = [&](std::size_t i) { return kNear * line.radius[i]; };
  for_each_neighbourhood(sections, s, reach, [&](std::size_t i, const auto& near) {
    scales[i].window = median_of(near, [](const TubeSection& t) { return t.scale.window; });
    scales[i].order = int(median_of(near, [](const TubeSection& t) { return t.scale.order; }));
  });
  return scales;
}

/// The noise of the vessel around each point.
std::vector<TubeScale> learn_noise(const std::vector<TubeSection>& sections, const Polyline& line,
                                   const std::vector<double>& s) {
  constexpr double kNear = 10.0;  // radii of the healthy vessel: more than a lesion is long
  std::vector<TubeScale> scales(sections.size());
  std::vector<double> radii = line.radius;
  const double reach = kNear * quantile(radii, 0.5);
  const auto everywhere = [reach](std::size_t) { return reach; };
  for_each_neighbourhood(sections, s, everywhere, [&](std::size_t i, const auto& near) {
    scales[i].least_noise = median_of(near, [](const TubeSection& t) { return t.noise; });
  });
  return scales;
}

}  // namespace

std::vector<TubeSection> measure_tube(const WallPoints& points, const Polyline& line,
                                      std::size_t first, std::size_t last, const Wall* wall,
                                      ScaleChoice choice) {
  constexpr std::size_t kSparse = 8;  // every eighth point tells the noise well enough
  const std::vector<double> s = arc_length(line.points);
  std::vector<TubeSection> sections(line.points.size());
  std::vector<TubeScale> scales(line.points.size());
  const auto measure = [&](const std::vector<std::size_t>& places, TubeEffort asked) {
    parallel_for_uneven(std::ptrdiff_t(places.size()), [&](std::ptrdiff_t n) {
      const std::size_t i = places[std::size_t(n)];
      const TubeEffort effort = scales[i].window > 0.0 ? asked : TubeEffort::measure;
      const double reach = course_reach(effort) * direction_reach(line, i);
      sections[i] = fit_tube(points, fit_curve(line, s, i, reach), line.radius[i], line.extent[i],
                             wall, effort, scales[i]);
    });
  };
  // Every n-th place, or such as stand a radius apart.
  const auto places = [&](std::size_t stride, double apart) {
    std::vector<std::size_t> some;
    for (std::size_t i = first; i < last; i += stride)
      if (some.empty() || s[i] - s[some.back()] >= apart * line.radius[i]) some.push_back(i);
    return some;
  };
  const std::vector<std::size_t> all = places(1, 0.0);
  if (points.correlation_length() > 0.0) {
    measure(places(kSparse, 0.0), TubeEffort::measure);
    scales = learn_noise(sections, line, s);
    measure(all, TubeEffort::measure);
  } else if (choice == ScaleChoice::everywhere) {
    measure(all, TubeEffort::measure);
    scales = settle_scales(sections, line, s);
    std::vector<std::size_t> seen;
    std::copy_if(all.begin(), all.end(), std::back_inserter(seen),
                 [&](std::size_t i) { return bool(sections[i].valid); });
    measure(seen, TubeEffort::measure);
  } else {
    measure(places(1, 1.0), TubeEffort::measure);
    scales = settle_scales(sections, line, s);
    measure(all, TubeEffort::follow);
  }
  return sections;
}

}  // namespace angio::centerline

#include "reconstruction/detail/tube_projection.hpp"

#include <algorithm>
#include <cmath>

#include "reconstruction/detail/tube_chord.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kLeastSine = 0.2;  ///< between ray and curve: a tube seen from its end is no tube
constexpr double kFewestPixelsAround = 3.0;

/// A ray and the stretch between two samples.
struct Passage {
  Vec3 direction;  ///< of the ray
  const CurvePoint* from;
  const CurvePoint* to;
  Vec3 away_from, away_to;    ///< from the samples to the ray, at right angles to it
  double fall_from, fall_to;  ///< along the tangents: their sign changes at the foot

  Passage(const Vec3& source, const Vec3& ray, const CurvePoint& a, const CurvePoint& b)
      : direction(ray),
        from(&a),
        to(&b),
        away_from(across(source - a.point)),
        away_to(across(source - b.point)),
        fall_from(dot(away_from, a.tangent)),
        fall_to(dot(away_to, b.tangent)) {}
  [[nodiscard]] Vec3 across(const Vec3& v) const { return v - dot(v, direction) * direction; }
  [[nodiscard]] bool has_foot() const { return fall_from >= 0.0 && fall_to < 0.0; }
  [[nodiscard]] double part() const { return fall_from / (fall_from - fall_to); }
};

/// The tube where a ray passes it.
struct LocalTube {
  double part;
  Vec3 away, tangent;          ///< `tangent` as it is interpolated, not of unit length
  double length;               ///< of `tangent`
  double log_slope, log_bend;  ///< by the parameter
  ObliqueTube shape;           ///< by arc length
  ObliqueChord chord;

  LocalTube(const FrameRays& rays, const Passage& p, double width_pixels) : part(p.part()) {
    const auto between = [this](const auto& a, const auto& b) { return a + part * (b - a); };
    away = between(p.away_from, p.away_to);
    tangent = between(p.from->tangent, p.to->tangent);
    length = norm(tangent);
    log_slope = between(p.from->log_slope, p.to->log_slope);
    log_bend = between(p.from->log_bend, p.to->log_bend);
    shape.distance = norm(away);
    shape.log_radius = between(p.from->log_radius, p.to->log_radius);
    shape.slope = log_slope / length;
    shape.bend = log_bend / (length * length);
    shape.cosine = dot(tangent, p.direction) / length;
    shape.width = width_pixels * rays.pixel_mm * rays.view.see(p.from->point).depth;
    // Seen from its end a tube is no tube (find_hits()).
    if (sine() >= kLeastSine) chord = oblique_chord(shape);
  }
  [[nodiscard]] double sine() const {
    return std::sqrt(std::max(0.0, 1.0 - shape.cosine * shape.cosine));
  }
};

/// How far from its axis a tube that widens is looked for: as an even cone is seen at the least
/// angle.
double widest_seen(const CurvePoint& a, const CurvePoint& b) {
  const double radius = std::exp(std::max(a.log_radius, b.log_radius));
  const double slope = radius * std::max(std::abs(a.log_slope), std::abs(b.log_slope));
  return radius * std::hypot(1.0, slope / kLeastSine);
}

double reach_of(Reach reach, double radius, double pixel_mm, double width_pixels) {
  const double blurred = radius + 0.5 * width_pixels * pixel_mm;
  return reach == Reach::tube ? blurred
                              : blurred + std::max(radius, kFewestPixelsAround * pixel_mm);
}

/// A rectangle of pixels.
struct PixelBox {
  int first_column, last_column, first_row, last_row;
};
PixelBox box_around(const FrameRays& rays, const Vec3& a, const Vec3& b, double reach) {
  const angiogram::SeenPoint p = rays.view.see(a), q = rays.view.see(b);
  if (!(p.depth > 0.0) || !(q.depth > 0.0)) return {0, -1, 0, -1};
  const double depth = std::min(p.depth, q.depth);
  const double columns = 1.1 * reach / (norm(rays.frame.column_step) * depth) + 1.0;
  const double rows = 1.1 * reach / (norm(rays.frame.row_step) * depth) + 1.0;
  const auto low = [](double x, int count) {
    return int(std::clamp(std::floor(x), 0.0, double(count)));
  };
  const auto high = [](double x, int count) {
    return int(std::clamp(std::ceil(x), -1.0, double(count - 1)));
  };
  return {low(std::min(p.column, q.column) - columns, rays.frame.columns),
          high(std::max(p.column, q.column) + columns, rays.frame.columns),
          low(std::min(p.row, q.row) - rows, rays.frame.rows),
          high(std::max(p.row, q.row) + rows, rays.frame.rows)};
}

/// Calls visit(pixel) for the pixels of a box.
template <class Visit>
void for_each_pixel(const PixelBox& box, int columns, const Visit& visit) {
  for (int row = box.first_row; row <= box.last_row; ++row)
    for (int c = box.first_column; c <= box.last_column; ++c) visit(row * columns + c);
}

/// How the way of a ray changes with one hit: `by_way` of its way, `by_middle` of that way's
/// middle.
void add_gradient(const FrameRays& rays, const SampledCurves& sampled, double width_pixels,
                  const TubeHit& hit, double by_way, double by_middle, WayGradient& gradient) {
  const TreeCurve& curve = sampled.curves->curves[std::size_t(hit.curve)];
  const auto& points = sampled.points[std::size_t(hit.curve)];
  const std::size_t s = std::size_t(hit.sample);
  const Passage p(rays.frame.source, rays.direction(hit.pixel), points[s], points[s + 1]);
  const LocalTube tube(rays, p, width_pixels);
  // Backwards through the chord, the shape by arc length, and what is interpolated.
  const auto by = [&](double ObliqueLength::*what) {
    return by_way * tube.chord.way.*what + by_middle * tube.chord.middle.*what;
  };
  gradient.by_width += by(&ObliqueLength::by_width) * tube.shape.width;
  const double to_log_radius = by(&ObliqueLength::by_log_radius);
  const double to_slope = by(&ObliqueLength::by_slope) / tube.length;
  const double to_bend = by(&ObliqueLength::by_bend) / (tube.length * tube.length);
  const double away = tube.shape.distance;
  const Vec3 to_away = away > 0.0 ? by(&ObliqueLength::by_distance) / away * tube.away : Vec3{};
  const Vec3 along = tube.tangent / tube.length;
  const double to_length =
      -(to_slope * tube.log_slope + 2.0 * to_bend * tube.log_bend) / tube.length;
  const Vec3 to_tangent =
      by(&ObliqueLength::by_cosine) / tube.length * (p.direction - tube.shape.cosine * along) +
      to_length * along;
  const double to_part = dot(to_away, p.away_to - p.away_from) +
                         dot(to_tangent, p.to->tangent - p.from->tangent) +
                         to_log_radius * (p.to->log_radius - p.from->log_radius) +
                         to_slope * (p.to->log_slope - p.from->log_slope) +
                         to_bend * (p.to->log_bend - p.from->log_bend) +
                         by_middle * dot(p.direction, p.to->point - p.from->point);
  const double fall = p.fall_from - p.fall_to;
  const double to_fall_from = -to_part * p.fall_to / (fall * fall);
  const double to_fall_to = to_part * p.fall_from / (fall * fall);
  const std::array<double, 2> share = {1.0 - tube.part, tube.part};
  const std::array<double, 2> to_fall = {to_fall_from, to_fall_to};
  const std::array<const CurvePoint*, 2> end = {p.from, p.to};
  const std::array<Vec3, 2> end_away = {p.away_from, p.away_to};
  for (std::size_t e = 0; e < 2; ++e) {
    const Vec3 to_end_away = share[e] * to_away + to_fall[e] * end[e]->tangent;
    const Vec3 to_point = share[e] * by_middle * p.direction - p.across(to_end_away);
    const Vec3 to_end_tangent = share[e] * to_tangent + to_fall[e] * end_away[e];
    const SplinePlace& place = curve.samples[s + e];
    for (std::size_t a = 0; a < 4; ++a) {
      const std::size_t n = std::size_t(place.first_node) + a;
      const Vec3 to_node = place.value[a] * to_point + place.slope[a] * to_end_tangent;
      const int first = curve.first_parameter + 3 * int(n);
      gradient.by_parameter.emplace_back(first, dot(to_node, curve.first_normal[n]));
      gradient.by_parameter.emplace_back(first + 1, dot(to_node, curve.second_normal[n]));
      gradient.by_parameter.emplace_back(
          first + 2, share[e] * (to_log_radius * place.value[a] + to_slope * place.slope[a] +
                                 to_bend * place.bend[a]));
    }
    // The frame's motion moves the tree the other way.
    const Vec3 turn = -cross(end[e]->point, to_point) - cross(end[e]->tangent, to_end_tangent);
    for (int axis = 0; axis < 3; ++axis) {
      gradient.by_motion[std::size_t(axis)] += turn[axis];
      gradient.by_motion[std::size_t(axis) + 3] -= to_point[axis];
    }
  }
}

}  // namespace

SampledCurves sample_curves(const TreeCurves& curves) {
  SampledCurves sampled{&curves, {}};
  for (const TreeCurve& curve : curves.curves) {
    std::vector<CurvePoint>& points = sampled.points.emplace_back();
    for (const SplinePlace& place : curve.samples) points.push_back(curve.at(place));
  }
  return sampled;
}

std::vector<TubeHit> find_hits(const FrameRays& rays, const SampledCurves& curves,
                               double width_pixels, Reach reach, const std::vector<char>& wanted) {
  std::vector<TubeHit> hits;
  for (std::size_t c = 0; c < curves.points.size(); ++c)
    for (std::size_t s = 0; s + 1 < curves.points[c].size(); ++s) {
      const CurvePoint &a = curves.points[c][s], &b = curves.points[c][s + 1];
      const double pixel = rays.pixel_mm * rays.view.see(a.point).depth;
      const double most = reach_of(reach, widest_seen(a, b), pixel, width_pixels);
      const auto look = [&](int index) {
        if (!wanted.empty() && wanted[std::size_t(index)] == 0) return;
        const Passage passage(rays.frame.source, rays.direction(index), a, b);
        if (!passage.has_foot()) return;
        const LocalTube tube(rays, passage, width_pixels);
        const double away = tube.shape.distance;
        if (away >= most || tube.sine() < kLeastSine) return;
        const double side = dot(cross(tube.tangent, passage.direction), tube.away);
        const Vec3 middle = a.point + tube.part * (b.point - a.point);
        hits.push_back(
            {index, int(c), int(s), tube.part, away, side < 0.0 ? -away : away,
             std::exp(tube.shape.log_radius), tube.chord.way.value,
             dot(middle - rays.frame.source, passage.direction) + tube.chord.middle.value});
      };
      for_each_pixel(box_around(rays, a.point, b.point, most), rays.frame.columns, look);
    }
  std::stable_sort(hits.begin(), hits.end(),
                   [](const TubeHit& x, const TubeHit& y) { return x.pixel < y.pixel; });
  return hits;
}

std::vector<int> find_end_pixels(const FrameRays& rays, const SampledCurves& curves,
                                 double width_pixels) {
  std::vector<int> pixels;
  const auto add = [&](const CurvePoint& at, double blank, double sign) {
    const double pixel = rays.pixel_mm * rays.view.see(at.point).depth;
    const double most = reach_of(Reach::surroundings, std::exp(at.log_radius), pixel, width_pixels);
    const auto look = [&](int index) {
      const Vec3 direction = rays.direction(index);
      const Vec3 from = rays.frame.source - at.point;
      const Vec3 away = from - dot(from, direction) * direction;
      const double beyond = sign * dot(away, normalized(at.tangent));
      if (norm(away) < std::hypot(most, blank) && beyond > -blank) pixels.push_back(index);
    };
    for_each_pixel(box_around(rays, at.point, at.point, std::hypot(most, blank)),
                   rays.frame.columns, look);
  };
  for (std::size_t c = 0; c < curves.points.size(); ++c) {
    const TreeCurve& curve = curves.curves->curves[c];
    if (curve.parent < 0) add(curves.points[c].front(), curve.blank_start, -1.0);
    add(curves.points[c].back(), curve.blank_end, 1.0);
  }
  return pixels;
}

double way_of_ray(const FrameRays& rays, const SampledCurves& curves, double width_pixels,
                  const TubeHit* first, const TubeHit* last, WayGradient* gradient) {
  std::vector<const TubeHit*> hits;
  for (const TubeHit* hit = first; hit != last; ++hit)
    if (hit->way > 0.0) hits.push_back(hit);
  const auto start = [](const TubeHit* hit) { return hit->middle - 0.5 * hit->way; };
  const auto end = [](const TubeHit* hit) { return hit->middle + 0.5 * hit->way; };
  std::stable_sort(hits.begin(), hits.end(),
                   [&](const TubeHit* a, const TubeHit* b) { return start(a) < start(b); });
  double way = 0.0;
  for (std::size_t h = 0; h < hits.size();) {
    const TubeHit* opens = hits[h];
    const TubeHit* closes = opens;
    for (++h; h < hits.size() && start(hits[h]) < end(closes); ++h)
      if (end(hits[h]) > end(closes)) closes = hits[h];
    way += end(closes) - start(opens);
    if (!gradient) continue;
    if (opens == closes) {
      add_gradient(rays, curves, width_pixels, *opens, 1.0, 0.0, *gradient);
    } else {
      add_gradient(rays, curves, width_pixels, *opens, 0.5, -1.0, *gradient);
      add_gradient(rays, curves, width_pixels, *closes, 0.5, 1.0, *gradient);
    }
  }
  return way;
}

}  // namespace angio::reconstruction::detail

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/units.hpp"
#include "meshing/detail/balloon_shape.hpp"

namespace angio::meshing::detail {
namespace {

using std::numbers::pi;

// Of a cone to the axis: the middle of the 30 to 45 degrees of balloons; representative.
constexpr double kConeAngle = 37.5 * units::kPi / 180.0;
constexpr double kNeckInDiameters =
    0.5;                                // length over its diameter; longer, its triangles get thin
constexpr double kConeAspect = 2.5;     // of a cone's quadrilaterals, along over around
constexpr double kMostConeShare = 0.3;  // of the rings, on each cone

double slant(const BalloonPlan& plan) {
  return (plan.rest_radius - plan.neck_radius) / std::sin(kConeAngle);
}
double neck_length(const BalloonPlan& plan) { return kNeckInDiameters * 2.0 * plan.neck_radius; }

/// Over the radius of a circle, that of the polygon's vertices with its area.
double polygon_factor(int vertex_count) {
  const double angle = 2.0 * pi / vertex_count;
  return std::sqrt(angle / std::sin(angle));
}

BalloonRings hemisphere_rings(const BalloonPlan& plan) {
  const double r = plan.rest_radius;
  const double meridian = plan.meridian();
  const double polygon = polygon_factor(plan.ring_vertex_count);
  const double quarter = 0.5 * pi * r;
  BalloonRings rings;
  for (int i = 0; i < plan.ring_count; ++i) {
    const double m = meridian * (i + 1) / (plan.ring_count + 1);
    const double past = std::max(0.0, quarter - std::min(m, meridian - m));
    const double rise = plan.rise(past);
    double position = r + m - quarter;
    if (past > 0.0) position = m < quarter ? r - rise : r + plan.cylinder_length + rise;
    rings.position.push_back(position);
    rings.radius.push_back(polygon * r * std::cos(past / r));
    rings.past_end.push_back(past);
  }
  return rings;
}

/// Steps along each cone: the radius grows by the same factor at each, so that a step is
/// kConeAspect edges of its ring.
int cone_step_count(const BalloonPlan& plan) {
  const double edge = 2.0 * pi / plan.ring_vertex_count;  // of a ring of radius 1
  const double factor = 1.0 + kConeAspect * edge * std::sin(kConeAngle);
  const double steps = std::log(plan.rest_radius / plan.neck_radius) / std::log(factor);
  const int most = std::max(1, int(kMostConeShare * plan.ring_count) - kNeckRings);
  return std::clamp(int(std::ceil(steps)), 1, most);
}

BalloonRings cone_rings(const BalloonPlan& plan) {
  const int on_cone = cone_step_count(plan);
  const int on_cylinder = plan.ring_count - 2 * (kNeckRings - 1) - 2 * on_cone - 1;
  const double polygon = polygon_factor(plan.ring_vertex_count);
  BalloonRings rings;
  const auto add = [&](double position, double radius, double past) {
    rings.position.push_back(position);
    rings.radius.push_back(polygon * radius);
    rings.past_end.push_back(past);
  };
  const double end = plan.end_length();
  for (int i = 0; i < kNeckRings - 1; ++i)  // the neck's outer end
    add(neck_length(plan) * i / (kNeckRings - 1), plan.neck_radius,
        slant(plan) + neck_length(plan));
  for (int i = 0; i < on_cone; ++i) {
    const double radius =
        plan.neck_radius * std::pow(plan.rest_radius / plan.neck_radius, double(i) / on_cone);
    const double past = plan.meridian_to(radius);
    add(end - plan.rise(past), radius, past);
  }
  for (int i = 0; i <= on_cylinder; ++i)
    add(end + plan.cylinder_length * i / on_cylinder, plan.rest_radius, 0.0);
  for (int i = on_cone + kNeckRings - 2; i >= 0; --i)  // the proximal end's mirror image
    add(plan.total_length() - rings.position[std::size_t(i)],
        rings.radius[std::size_t(i)] / polygon, rings.past_end[std::size_t(i)]);
  return rings;
}

}  // namespace

double BalloonPlan::end_length() const {
  return ends == BalloonEnds::hemispheres ? rest_radius : rise(slant(*this)) + neck_length(*this);
}

double BalloonPlan::meridian() const {
  return cylinder_length +
         (ends == BalloonEnds::hemispheres ? pi * rest_radius : 2.0 * slant(*this));
}

double BalloonPlan::meridian_to(double radius) const {
  if (ends == BalloonEnds::hemispheres)
    return rest_radius * std::acos(std::min(1.0, radius / rest_radius));
  return std::clamp((rest_radius - radius) / std::sin(kConeAngle), 0.0, slant(*this));
}

double BalloonPlan::rise(double past_end) const {
  return ends == BalloonEnds::hemispheres ? rest_radius * std::sin(past_end / rest_radius)
                                          : past_end * std::cos(kConeAngle);
}

BalloonRings balloon_rings(const BalloonPlan& plan) {
  return plan.ends == BalloonEnds::hemispheres ? hemisphere_rings(plan) : cone_rings(plan);
}

std::vector<Triangle> balloon_triangles(int ring_count, int ring_vertex_count) {
  std::vector<Triangle> triangles;
  const int n = ring_vertex_count;
  const int pole = ring_count * n;
  for (int k = 0; k < n; ++k) triangles.push_back({pole, (k + 1) % n, k});
  for (int i = 0; i + 1 < ring_count; ++i)
    for (int k = 0; k < n; ++k) {
      const int a = i * n + k;
      const int b = i * n + (k + 1) % n;
      const int c = b + n;
      const int d = a + n;
      if ((i + k) % 2 == 0) {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
      } else {
        triangles.push_back({a, b, d});
        triangles.push_back({b, c, d});
      }
    }
  const int last = (ring_count - 1) * n;
  for (int k = 0; k < n; ++k) triangles.push_back({pole + 1, last + k, last + (k + 1) % n});
  return triangles;
}

}  // namespace angio::meshing::detail

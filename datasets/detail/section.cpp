#include "datasets/detail/section.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"

namespace angio::datasets::detail {
namespace {

constexpr int kRayCount = 128;
constexpr double kToleranceMm = 1e-9;
constexpr double kLeastStepMm = 1e-3;

}  // namespace

double distance_to_wall(const LumenShape& shape, const Vec3& from, const Vec3& direction) {
  const auto f = [&](double t) {
    return shape.signed_distance(from + t * direction, LumenShape::Ends::continued);
  };
  // Ball by ball until the wall lies between `inside` and `outside`; then regula falsi, with a
  // bisection now and then where the wall bends.
  double inside = 0.0, f_inside = f(0.0);
  ANGIO_EXPECT(f_inside < 0.0);
  double outside = std::max(-f_inside, kLeastStepMm), f_outside = f(outside);
  while (f_outside < 0.0) {
    inside = outside;
    f_inside = f_outside;
    outside = inside + std::max(-f_inside, kLeastStepMm);
    f_outside = f(outside);
  }
  for (int i = 0; i < 60 && outside - inside > kToleranceMm; ++i) {
    const double middle = i % 3 == 2
                              ? 0.5 * (inside + outside)
                              : inside + (outside - inside) * f_inside / (f_inside - f_outside);
    const double f_middle = f(middle);
    if (std::abs(f_middle) < kToleranceMm) return middle;
    (f_middle < 0.0 ? inside : outside) = middle;
    (f_middle < 0.0 ? f_inside : f_outside) = f_middle;
  }
  return 0.5 * (inside + outside);
}

double section_area(const LumenShape& shape, const Vec3& center, const Vec3& normal) {
  const Vec3 u = any_perpendicular(normal);
  const Vec3 v = cross(normal, u);
  double sum = 0.0;
  for (int ray = 0; ray < kRayCount; ++ray) {
    const double angle = 2.0 * units::kPi * ray / kRayCount;
    const double rho = distance_to_wall(shape, center, std::cos(angle) * u + std::sin(angle) * v);
    sum += rho * rho;
  }
  return units::kPi * sum / kRayCount;
}

}  // namespace angio::datasets::detail

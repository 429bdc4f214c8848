#include "simulation/run/balloon_section.hpp"

#include <cmath>
#include <optional>

#include "core/surface_section.hpp"
#include "core/units.hpp"

namespace angio::simulation::detail {

double diameter_across(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x,
                       const Vec3& point, const Vec3& guess) {
  constexpr int kIterations = 8;
  constexpr double kStep = 0.5;    // between sections, in radii
  constexpr double kStill = 1e-6;  // turn of the axis
  Vec3 axis = guess;
  std::optional<SurfaceSection> at = nearest_section(triangles, x, point, axis);
  if (!at) return 0.0;
  for (int i = 0; i < kIterations; ++i) {
    const Vec3 step = kStep * std::sqrt(at->area / units::kPi) * axis;
    const auto before = nearest_section(triangles, x, at->middle - step, axis);
    const auto behind = nearest_section(triangles, x, at->middle + step, axis);
    if (!before || !behind || !(distance(before->middle, behind->middle) > 0.0)) break;
    const Vec3 next = normalized(behind->middle - before->middle);
    const auto section = nearest_section(triangles, x, point, next);
    if (!section) break;
    const double turn = distance(next, axis);
    axis = next;
    at = section;
    if (turn < kStill) break;
  }
  return 2.0 * std::sqrt(at->area / units::kPi);
}

}  // namespace angio::simulation::detail

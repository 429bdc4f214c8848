#include "reconstruction/detail/ray_weights.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kTurn = 2.0 * units::kPi;
constexpr double kRise = 10.0 * units::kPi / 180.0;

/// c: 0 outside the arc.
double share(const Orbit& orbit, double angle) {
  const double from_end = std::min(angle - orbit.first_angle, orbit.last_angle - angle);
  if (from_end <= 0.0) return 0.0;
  const double rise = std::min(kRise, 0.5 * orbit.arc());
  if (from_end >= rise) return 1.0;
  const double s = std::sin(0.5 * units::kPi * from_end / rise);
  return s * s;
}

double sum_of_turns(const Orbit& orbit, double angle) {
  double sum = 0.0;
  const double first = std::ceil((orbit.first_angle - angle) / kTurn);
  for (double n = first; angle + n * kTurn <= orbit.last_angle; n += 1.0)
    sum += share(orbit, angle + n * kTurn);
  return sum;
}

}  // namespace

std::vector<float> ray_weights(const Orbit& orbit, std::size_t frame,
                               const std::vector<double>& across_mm) {
  const double angle = orbit.angle[frame];
  const double own = share(orbit, angle), all_own = sum_of_turns(orbit, angle);
  std::vector<float> weights;
  weights.reserve(across_mm.size());
  for (const double u : across_mm) {
    const double fan = std::atan2(u, orbit.radius[frame]);
    weights.push_back(float(own / (all_own + sum_of_turns(orbit, angle + units::kPi - 2.0 * fan))));
  }
  return weights;
}

}  // namespace angio::reconstruction::detail

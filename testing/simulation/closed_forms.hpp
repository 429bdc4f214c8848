#pragma once

#include <cmath>

/// Exact states of the seed paper's polyurethane, an incompressible Mooney-Rivlin membrane:
///     w = C1 (l1^2 + l2^2 + (l1 l2)^-2 - 3) + C2 (l1^-2 + l2^-2 + (l1 l2)^2 - 3)
namespace angio::simulation::testing {

inline constexpr double kC1 = 1.031, kC2 = 3.69;  ///< [MPa]

struct TubeState {
  double around = 1.0, along = 1.0;
  double load_mpa = 0.0;  ///< p R / H
};

/// The closed free tube at a stretch around: dw/dl1 = p R l1 l2 / H, dw/dl2 = p R l1^2 / (2 H),
/// hence l1 dw/dl1 = 2 l2 dw/dl2, by bisection.
inline TubeState closed_tube(double l1) {
  const auto slope = [](double a, double b) {  // dw/da
    return 2.0 * kC1 * (a - std::pow(a, -3) / (b * b)) + 2.0 * kC2 * (a * b * b - std::pow(a, -3));
  };
  double low = 0.3, high = 1.5;
  for (int i = 0; i < 100; ++i) {
    const double l2 = 0.5 * (low + high);
    (l1 * slope(l1, l2) > 2.0 * l2 * slope(l2, l1) ? low : high) = l2;
  }
  return {l1, low, slope(l1, low) / (l1 * low)};
}

}  // namespace angio::simulation::testing

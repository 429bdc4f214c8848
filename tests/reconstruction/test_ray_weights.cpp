#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "reconstruction/detail/ray_weights.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction::detail {
namespace {

/// The weight of the ray at fan angle `fan` of a source at `angle`, by an orbit with a frame there.
double weight_at(Orbit orbit, double angle, double fan) {
  if (angle < orbit.first_angle || angle > orbit.last_angle) return 0.0;
  orbit.angle[0] = angle;
  return double(ray_weights(orbit, 0, {orbit.radius[0] * std::tan(fan)})[0]);
}

class RayWeights : public testing::TestWithParam<double> {};

TEST_P(RayWeights, OfARaySumToOneOverItsMeasurements) {
  const Orbit orbit = fit_orbit(tests::turn(40, 0.0, GetParam()));
  const double turn = 2.0 * units::kPi;
  for (double part = 0.05; part < 1.0; part += 0.1)
    for (const double fan : {-0.15, -0.03, 0.0, 0.08, 0.15}) {
      const double angle = orbit.first_angle + part * orbit.arc();
      double sum = 0.0;
      for (int n = -2; n <= 2; ++n)
        sum += weight_at(orbit, angle + n * turn, fan) +
               weight_at(orbit, angle + units::kPi - 2.0 * fan + n * turn, -fan);
      EXPECT_NEAR(sum, 1.0, 1e-5) << part << " " << fan;
    }
}

INSTANTIATE_TEST_SUITE_P(Arcs, RayWeights,
                         testing::Values(120.0, 185.0, 210.0, 300.0, 360.0, 400.0),
                         [](const auto& arc) { return std::to_string(int(arc.param)); });

TEST(RayWeightsOfAFullTurn, AreHalvesAwayFromItsEnds) {
  const Orbit orbit = fit_orbit(tests::turn(361, 0.0, 359.0));
  EXPECT_NEAR(weight_at(orbit, orbit.first_angle + 0.25 * orbit.arc(), 0.0), 0.5, 1e-6);
}

}  // namespace
}  // namespace angio::reconstruction::detail

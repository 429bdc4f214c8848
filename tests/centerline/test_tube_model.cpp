#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "centerline/detail/tube_model.hpp"
#include "core/centerline.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

// Where a line crosses a cone aslant the largest ball is that of the cone's axis: the distance from
// the axis to the wall is r cos alpha. The largest circle of the section lies to the wide side, and
// from its centre the wall of the narrow side is nearer.
TEST(FitTube, LargestBallOfAConeThatTheLineCrossesAslant) {
  constexpr double kTilt = 20.0, kOpening = 20.0;  // degrees
  const double tilt = kTilt * units::kPi / 180.0, slope = std::tan(kOpening * units::kPi / 180.0);
  const Vec3 axis{std::sin(tilt), 0.0, std::cos(tilt)},
      across{std::cos(tilt), 0.0, -std::sin(tilt)};
  std::vector<Vec3> wall;
  for (double t = -2.0; t < 2.5; t += 0.05)
    for (int i = 0; i < 64; ++i) {
      const double turn = 2.0 * units::kPi * i / 64.0, r = 1.0 + slope * t;
      wall.push_back(t * axis + r * std::cos(turn) * across + Vec3{0.0, r * std::sin(turn), 0.0});
    }
  Polyline line;
  for (double z = -2.0; z <= 2.0; z += 0.1) {
    line.points.push_back({0.0, 0.0, z});
    line.radius.push_back(1.0);
    line.extent.push_back(1.2);
  }
  const std::size_t middle = line.points.size() / 2;
  const TubeSection section =
      fit_tube(WallPoints(wall),
               fit_curve(line, arc_length(line.points), middle, course_reach(TubeEffort::measure)),
               1.0, 1.2, nullptr, TubeEffort::measure);
  ASSERT_TRUE(section.valid);
  EXPECT_NEAR(section.inscribed_radius, std::cos(std::atan(slope)), 0.015);
}

}  // namespace
}  // namespace angio::centerline

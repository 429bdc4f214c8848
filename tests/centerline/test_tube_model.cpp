#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "centerline/detail/tube_model.hpp"
#include "core/centerline.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

constexpr double kSlope = 0.36;  // of the cones' wall

/// A cone whose axis crosses the z axis in the origin, by 20 degrees, turned about z. Its half axes
/// there are `aspect` and 1.
std::vector<Vec3> slanting_cone(double aspect, double turn_degrees) {
  const double tilt = 20.0 * units::kPi / 180.0, turn = turn_degrees * units::kPi / 180.0;
  const Vec3 axis{std::sin(tilt), 0.0, std::cos(tilt)},
      across{std::cos(tilt), 0.0, -std::sin(tilt)};
  std::vector<Vec3> wall;
  for (double t = -2.0; t < 2.5; t += 0.04)
    for (int i = 0; i < 96; ++i) {
      const double theta = 2.0 * units::kPi * i / 96.0, r = 1.0 + kSlope * t;
      const Vec3 p =
          t * axis + aspect * r * std::cos(theta) * across + Vec3{0.0, r * std::sin(theta), 0.0};
      wall.push_back({std::cos(turn) * p.x - std::sin(turn) * p.y,
                      std::sin(turn) * p.x + std::cos(turn) * p.y, p.z});
    }
  return wall;
}

double inscribed_radius(const std::vector<Vec3>& wall) {
  Polyline line;
  for (double z = -2.0; z <= 2.0; z += 0.1) {
    line.points.push_back({0.0, 0.0, z});
    line.radius.push_back(1.0);
    line.extent.push_back(1.2);
  }
  const auto curve = fit_curve(line, arc_length(line.points), line.points.size() / 2,
                               course_reach(TubeEffort::measure));
  const TubeSection section =
      fit_tube(WallPoints(wall), curve, 1.0, 1.2, nullptr, TubeEffort::measure);
  return section.valid ? section.inscribed_radius : 0.0;
}

/// By every place of the plane z = 0, 0.01 apart.
double largest_distance(const std::vector<Vec3>& wall) {
  double largest = 0.0;
  for (double x = -0.1; x < 0.6; x += 0.01)
    for (double y = -0.05; y < 0.06; y += 0.01) {
      double nearest = 1e300;
      for (const Vec3& p : wall) nearest = std::min(nearest, norm_squared(p - Vec3{x, y, 0.0}));
      largest = std::max(largest, std::sqrt(nearest));
    }
  return largest;
}

// Where a line crosses a cone aslant the largest ball is that of the cone's axis: the distance from
// the axis to the wall is r cos alpha. The largest circle of the section lies to the wide side, and
// from its centre the wall of the narrow side is nearer.
TEST(FitTube, LargestBallOfAConeThatTheLineCrossesAslant) {
  EXPECT_NEAR(inscribed_radius(slanting_cone(1.0, 0.0)), std::cos(std::atan(kSlope)), 0.01);
}

TEST(FitTube, LargestBallDoesNotDependOnHowTheSectionLies) {
  for (const double aspect : {1.0, 1.3}) {
    const double largest = largest_distance(slanting_cone(aspect, 0.0));
    for (const double turn : {0.0, 11.0, 22.5, 40.0, 77.0})
      EXPECT_NEAR(inscribed_radius(slanting_cone(aspect, turn)), largest, 0.008)
          << aspect << ", " << turn;
  }
}

}  // namespace
}  // namespace angio::centerline

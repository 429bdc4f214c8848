#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "simulation/run/balloon_section.hpp"
#include "testing/simulation/models.hpp"

namespace angio::simulation::detail {
namespace {

constexpr double kRadius = 1.5;

TriangleMesh tube(double length = 20.0) {
  return testing::closed_tube(length, 61, 40, [](double) { return kRadius; });
}

Vec3 tilted(const Vec3& p, double angle) {
  return {std::cos(angle) * p.x + std::sin(angle) * p.z, p.y,
          -std::sin(angle) * p.x + std::cos(angle) * p.z};
}

TEST(DiameterAcross, DoesNotGrowWithTheTilt) {
  for (const double degrees : {0.0, 20.0, 40.0, 60.0}) {
    TriangleMesh balloon = tube();
    for (Vec3& p : balloon.vertices) p = tilted(p, degrees * units::kPi / 180.0);
    EXPECT_NEAR(diameter_across(balloon.triangles, balloon.vertices, {0, 0, 0}, {0, 0, 1}),
                2.0 * kRadius, 0.005 * kRadius)
        << degrees;
  }
}

TEST(DiameterAcross, OfABalloonAroundABendTakesTheLegThatIsNear) {
  constexpr double kBend = 6.0;  // radius of the half circle that the axis goes around
  TriangleMesh balloon = tube(units::kPi * kBend);
  for (Vec3& p : balloon.vertices) {
    const double angle = p.z / kBend, r = kBend + p.x;
    p = {r * std::cos(angle), p.y, r * std::sin(angle)};
  }
  const double angle = 1.2;
  const Vec3 on_axis{kBend * std::cos(angle), 0.0, kBend * std::sin(angle)};
  // The plane x = const cuts both legs.
  EXPECT_NEAR(diameter_across(balloon.triangles, balloon.vertices, on_axis, {0, 0, 1}),
              2.0 * kRadius, 0.01 * kRadius);
}

TEST(DiameterAcross, IsNothingBesideTheBalloon) {
  const TriangleMesh balloon = tube();
  EXPECT_EQ(diameter_across(balloon.triangles, balloon.vertices, {0, 0, 15}, {0, 0, 1}), 0.0);
}

}  // namespace
}  // namespace angio::simulation::detail

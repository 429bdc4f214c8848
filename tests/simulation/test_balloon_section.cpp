#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "simulation/bodies/drawn_wire.hpp"
#include "simulation/run/balloon_section.hpp"
#include "tests/simulation/models.hpp"

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

SimulationModel wired_balloon() {
  SimulationModel model = testing::make_model({});
  model.guidewire.clear();
  for (int i = 0; i <= 12; ++i) model.guidewire.push_back({0, 0, -6.0 + i});
  return model;
}

// How often the surface goes around a point, by its solid angles.
double winding(const TriangleMesh& mesh, const std::vector<Vec3>& x, const Vec3& p) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = normalized(x[std::size_t(t[0])] - p), b = normalized(x[std::size_t(t[1])] - p),
               c = normalized(x[std::size_t(t[2])] - p);
    sum += 2.0 * std::atan2(dot(a, cross(b, c)), 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
  }
  return sum / (4.0 * units::kPi);
}

TEST(DrawnWire, LiesAtTheStartWhereItWasPut) {
  const SimulationModel model = wired_balloon();
  const std::vector<Vec3> nodes = DrawnWire(model).nodes(model.balloon.vertices);
  ASSERT_EQ(nodes.size(), model.guidewire.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    EXPECT_LT(distance(nodes[i], model.guidewire[i]), 0.25) << i;
}

TEST(DrawnWire, StaysInABalloonThatHasMovedAndFolded) {
  const SimulationModel model = wired_balloon();
  const DrawnWire wire(model);
  std::vector<Vec3> x = model.balloon.vertices;
  for (Vec3& p : x) {
    // A flat balloon bent to a C around an axis of its own: the middle of its section is outside.
    const double angle = 4.0 * p.x, r = 0.3 + 0.1 * p.y;
    p = {5.0 + r * std::cos(angle), r * std::sin(angle), p.z};
  }
  TriangleMesh folded = model.balloon;
  folded.vertices = x;
  if (enclosed_volume(folded) < 0.0)
    for (Vec3& p : x) p.y = -p.y;
  const std::vector<Vec3> nodes = wire.nodes(x);
  for (std::size_t i = 1; i + 1 < nodes.size(); ++i)
    EXPECT_NEAR(winding(model.balloon, x, nodes[i]), 1.0, 1e-6) << i;
}

TEST(DrawnWire, OfNoGuidewireIsNothing) {
  SimulationModel model = testing::make_model({});
  model.guidewire.clear();
  EXPECT_TRUE(DrawnWire(model).nodes(model.balloon.vertices).empty());
}

}  // namespace
}  // namespace angio::simulation::detail

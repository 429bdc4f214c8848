#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "simulation/detail/equilibria.hpp"
#include "simulation/detail/numbering.hpp"
#include "simulation/detail/step.hpp"
#include "tests/simulation/models.hpp"

/// The solver's parts: numbering, precision, threads, ways to drive a balloon.
namespace angio::simulation::detail {
namespace {

SimulationModel capsule(double radius = 0.5, double length = 4.0) {
  SimulationModel model;
  model.balloon = testing::closed_tube(length, 13, 12, [&](double) { return radius; });
  model.balloon_rest = model.balloon.vertices;
  model.balloon_fixed.assign(model.balloon.vertices.size(), 0);
  model.measure_point = {0, 0, 1e-3};
  model.measure_tangent = {0, 0, 1};
  return model;
}

SimulationOptions rubber() {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.inflation.peak_pressure_atm = 2.0;
  return options;
}

TEST(Numbering, ColoursNeighboursDifferently) {
  SimulationModel model = capsule();
  const Numbering n = number_vertices(model.balloon, model.balloon_fixed);
  std::vector<int> color(n.order.size(), -1);
  for (std::size_t c = 0; c + 1 < n.begin.size(); ++c)
    for (int i = n.begin[c]; i < n.begin[c + 1]; ++i)
      color[std::size_t(n.order[std::size_t(i)])] = int(c);
  for (const Triangle& t : model.balloon.triangles) {
    EXPECT_NE(color[std::size_t(t[0])], color[std::size_t(t[1])]);
    EXPECT_NE(color[std::size_t(t[1])], color[std::size_t(t[2])]);
    EXPECT_NE(color[std::size_t(t[2])], color[std::size_t(t[0])]);
  }
  EXPECT_EQ(n.begin.size(), 5U);  // four colours
  EXPECT_EQ(n.begin.back(), int(n.order.size()));
}

TEST(Equilibria, VolumeControlAnswersWithThePressureThatGivesThatVolume) {
  const SimulationModel model = capsule();
  const SimulationOptions options = rubber();
  const double p = units::pascal_from_atm(1.0);
  const auto by_pressure = find_equilibria(model, options, {{Load::Kind::pressure, p}}, 1e-3);
  ASSERT_TRUE(by_pressure[0].converged);
  const auto by_volume =
      find_equilibria(model, options, {{Load::Kind::volume, by_pressure[0].volume}}, 1e-3);
  ASSERT_TRUE(by_volume[0].converged);
  EXPECT_NEAR(by_volume[0].volume, by_pressure[0].volume, 1e-4 * by_pressure[0].volume);
  EXPECT_NEAR(by_volume[0].pressure, p, 0.01 * p);
}

TEST(Equilibria, VolumeControlGoesPastTheLimitPoint) {
  // A closed tube of this rubber carries most at a hoop stretch of 2.5.
  const SimulationModel model = capsule();
  const double start = enclosed_volume(model.balloon);
  std::vector<Load> loads;
  for (const double growth : {2.0, 4.0}) loads.push_back({Load::Kind::volume, growth * start});
  const auto curve = find_equilibria(model, rubber(), loads, 1e-3);
  for (std::size_t i = 0; i < curve.size(); ++i) {
    EXPECT_TRUE(curve[i].converged) << i;
    EXPECT_NEAR(curve[i].volume, loads[i].value, 1e-3 * loads[i].value);
    EXPECT_GT(curve[i].pressure, 0.0);
  }
}

}  // namespace
}  // namespace angio::simulation::detail

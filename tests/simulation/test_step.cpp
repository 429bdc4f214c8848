#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/bodies/numbering.hpp"
#include "simulation/newton/equilibria.hpp"
#include "simulation/step/leap.hpp"
#include "testing/simulation/models.hpp"
#include "testing/simulation/states.hpp"

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

// With its poles held, or it would drift.
SimulationModel held_capsule() {
  SimulationModel model = capsule();
  model.balloon_fixed.back() = model.balloon_fixed.end()[-2] = 1;
  return model;
}

SimulationOptions quick(InflationControl control) {
  SimulationOptions options = rubber();
  options.balloon.wall_mm = 0.04;
  options.inflation.control = control;
  options.inflation.inflate_s = 0.5;
  options.inflation.hold_s = 0.1;
  options.inflation.deflate_s = 0.3;
  options.inflation.rest_s = 0.1;
  return options;
}

TEST(StepSolver, SinglePrecisionFollowsDouble) {
  SimulationModel model = held_capsule();
  for (Vec3& v : model.balloon.vertices) v += Vec3{210.0, -180.0, 290.0};  // as in a scan
  model.balloon_rest = model.balloon.vertices;
  const SimulationOptions options = quick(InflationControl::gas);
  const Scene scene = make_scene(model, options);
  EXPECT_EQ(precision_for(scene, options), Precision::single);
  const auto one =
      testing::states_of(*make_cpu_solver(scene, options, Precision::single), scene, options);
  const auto two =
      testing::states_of(*make_cpu_solver(scene, options, Precision::double_), scene, options);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t f = 0; f < one.size(); ++f) {
    EXPECT_NEAR(one[f].pressure, two[f].pressure, 1e-4 * two[f].pressure);
    for (std::size_t v = 0; v < one[f].x.size(); ++v)
      EXPECT_LT(distance(one[f].x[v], two[f].x[v]), 1e-4) << f;
  }
}

TEST(StepSolver, GivesTheSameBitsForAnyNumberOfThreads) {
  const SimulationOptions options = quick(InflationControl::gas);
  const Scene scene = make_scene(held_capsule(), options);
  const auto automatic = Precision::automatic;
  const auto one =
      testing::states_of(*make_cpu_solver(scene, options, automatic, 1), scene, options);
  const auto three =
      testing::states_of(*make_cpu_solver(scene, options, automatic, 3), scene, options);
  for (std::size_t f = 0; f < one.size(); ++f) EXPECT_EQ(one[f].x, three[f].x) << f;
}

TEST(Simulate, PressureControlFollowsTheInflationDevice) {
  const SimulationOptions options = quick(InflationControl::pressure);
  const double peak = options.inflation.peak_pressure_atm;
  double before = 0.0, last = 1.0;
  simulate(held_capsule(), options, [&](const SimulationFrame& f) {
    if (f.phase == Phase::inflate) {
      EXPECT_NEAR(f.pressure_atm - before, peak / 20.0, 1e-6);  // 20 frames
    }
    if (f.phase == Phase::hold) {
      EXPECT_NEAR(f.pressure_atm, peak, 1e-6);
    }
    before = last = f.pressure_atm;
  });
  EXPECT_NEAR(last, 0.0, 1e-3);
}

TEST(Simulate, VolumeControlReachesItsVolumeAndComesBack) {
  SimulationOptions options = quick(InflationControl::volume);
  const SimulationModel model = held_capsule();
  const double start = enclosed_volume(model.balloon);
  options.inflation.peak_volume_mm3 = 1.5 * start;
  double last = 0.0;
  simulate(model, options, [&](const SimulationFrame& f) {
    if (f.phase == Phase::hold) {
      EXPECT_NEAR(f.balloon_volume_mm3, 1.5 * start, 0.005 * start);
      EXPECT_GT(f.pressure_atm, 0.5);
    }
    last = f.balloon_volume_mm3;
  });
  EXPECT_NEAR(last, start, 0.01 * start);
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

// The lengths that leap_length gives for motions q^n e + r^n f of sweeps in a row.
std::vector<double> leaps_for(double q, double r, int sweeps) {
  LeapStatus leap;
  std::vector<double> lengths;
  for (int n = 1; n <= sweeps; ++n) {
    ++leap.sweeps;
    const double a[2] = {std::pow(q, n - 1), std::pow(r, n - 1)}, b[2] = {q * a[0], r * a[1]};
    lengths.push_back(leap_length(
        leap, {a[0] * b[0] + a[1] * b[1], a[0] * a[0] + a[1] * a[1], b[0] * b[0] + b[1] * b[1]}));
  }
  return lengths;
}

TEST(Leap, IsAllThatAGeometricSequenceHasLeft) {
  for (const double q : {0.7, 0.9, 0.95}) {
    const std::vector<double> lengths = leaps_for(q, 0.0, 6);
    double rest = 0.0;
    for (int n = 1; n < 2000; ++n) rest += std::pow(q, n);
    EXPECT_NEAR(lengths.back(), rest, 1e-9 * rest);
  }
}

TEST(Leap, IsNotTakenWhileMotionsTurnGrowOrShrinkFast) {
  for (const double length : leaps_for(0.9, -0.9, 6)) EXPECT_EQ(length, 0.0);
  for (const double length : leaps_for(1.05, 0.0, 6)) EXPECT_EQ(length, 0.0);
  for (const double length : leaps_for(0.5, 0.0, 6)) EXPECT_EQ(length, 0.0);
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

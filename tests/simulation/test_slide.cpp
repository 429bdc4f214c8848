#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "simulation/balloon_measures.hpp"
#include "simulation/materials/material.hpp"
#include "simulation/simulation.hpp"
#include "testing/simulation/models.hpp"

/// The distal neck slides along the wire.
namespace angio::simulation {
namespace {

constexpr double kRadius = 1.5, kLength = 14.0;
constexpr int kRings = 27, kAround = 20;  // a ring every half millimetre

/// A cylinder on the z axis, closed by caps: end ring and pole of either are tied; the distal end
/// slides, or not.
SimulationModel closed_cylinder(bool slides) {
  SimulationModel model;
  model.balloon = testing::closed_tube(kLength, kRings, kAround, [](double) { return kRadius; });
  model.balloon_rest = model.balloon.vertices;
  for (const Vec3& p : model.balloon.vertices) {
    model.balloon_fixed.push_back(std::abs(p.z) > 0.5 * kLength - 0.6 ? 1 : 0);
    model.balloon_sliding.push_back(slides && p.z > 0.5 * kLength - 0.6 ? 1 : 0);
  }
  model.guidewire = {{0, 0, -0.5 * kLength}, {0, 0, 0.5 * kLength}};
  model.measure_tangent = {0, 0, 1};
  return model;
}

SimulationOptions slow_inflation() {
  SimulationOptions options;
  // Fibres around it take the hoop stress: what is left stretches the tube along.
  options.balloon.chart = {{0.0, 2.0 * kRadius}, {12.0, 2.08 * kRadius}};
  options.inflation.peak_pressure_atm = 12.0;
  options.inflation.control = InflationControl::pressure;
  options.inflation.inflate_s = 1.0;
  options.inflation.hold_s = 0.5;
  options.inflation.deflate_s = 0.2;
  options.inflation.rest_s = 0.0;
  options.tolerance = 1e-4;
  options.backend = Backend::cpu;
  return options;
}

SimulationFrame at_peak(const SimulationModel& model, const SimulationOptions& options) {
  SimulationFrame peak;
  simulate(model, options, [&](const SimulationFrame& frame) {
    if (frame.phase == Phase::hold) peak = frame;
  });
  return peak;
}

/// The stretch along the axis between two rings around the middle.
double stretch_along(const SimulationModel& model, const SimulationFrame& frame) {
  double low = 0.0, high = 0.0, low_rest = 0.0, high_rest = 0.0;
  for (std::size_t v = 0; v < frame.balloon.size(); ++v) {
    const double z = model.balloon_rest[v].z;
    const bool is_near = std::abs(std::abs(z) - 3.0) < 1e-6;
    if (!is_near) continue;
    (z > 0.0 ? high : low) += frame.balloon[v].z;
    (z > 0.0 ? high_rest : low_rest) += z;
  }
  return (high - low) / (high_rest - low_rest);
}

/// The stretch around, near the middle.
double stretch_around(const SimulationModel& model, const SimulationFrame& frame) {
  double sum = 0.0, rest = 0.0;
  for (std::size_t v = 0; v < frame.balloon.size(); ++v)
    if (std::abs(model.balloon_rest[v].z) < 1.0) {
      sum += std::hypot(frame.balloon[v].x, frame.balloon[v].y);
      rest += std::hypot(model.balloon_rest[v].x, model.balloon_rest[v].y);
    }
  return sum / rest;
}

// A closed tube's ends carry p pi r^2, its wall 2 pi R (dw/dl2): l2 from l1 and the pressure.
TEST(Slide, AClosedTubeIsAsLongAsThePressureOnItsEndsStretchesIt) {
  const SimulationModel model = closed_cylinder(true);
  const SimulationOptions options = slow_inflation();
  const SimulationFrame peak = at_peak(model, options);
  const double l1 = stretch_around(model, peak);
  const double load = units::pascal_from_atm(peak.pressure_atm) * kRadius / options.balloon.wall_mm;
  const double expected =
      detail::tube_stretch_along(detail::membrane_law(options.balloon).base, l1, load);
  EXPECT_GT(expected, 1.01);
  EXPECT_NEAR(stretch_along(model, peak), expected, 0.1 * (expected - 1.0));
  // Where the neck is held, the length of the whole is.
  const SimulationModel held = closed_cylinder(false);
  EXPECT_NEAR(stretch_along(held, at_peak(held, options)), 1.0, 0.2 * (expected - 1.0));
}

// Uniform pressure in a straight tube: what the neck has slid is the tube's own growth, and the
// neck has neither turned nor grown.
TEST(Slide, TheNeckMovesAsOneBodyAlongTheWire) {
  const SimulationModel model = closed_cylinder(true);
  const SimulationFrame peak = at_peak(model, slow_inflation());
  const double slid = elongation_mm(model, peak.balloon);
  EXPECT_GT(std::abs(slid), 1e-3);
  EXPECT_TRUE(std::isnan(elongation_mm(closed_cylinder(false), peak.balloon))) << "held";
  for (std::size_t v = 0; v < peak.balloon.size(); ++v) {
    if (model.balloon_fixed[v] == 0) continue;
    const Vec3 moved = peak.balloon[v] - model.balloon.vertices[v];
    const double expected = model.balloon_sliding[v] != 0 ? slid : 0.0;
    EXPECT_NEAR(distance(moved, {0.0, 0.0, expected}), 0.0, 1e-5);
  }
}

TEST(SharpestFold, IsTheAngleBetweenNeighboursAndWhereItIs) {
  // Two triangles across the edge from (0, 0, 0) to (1, 0, 0), one of them turned by an angle.
  for (const double degrees : {0.0, 30.0, 119.0, 170.0}) {
    const double angle = degrees * units::kPi / 180.0;
    const TriangleMesh mesh{
        {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -std::cos(angle), std::sin(angle)}},
        {{0, 1, 2}, {1, 0, 3}}};
    const SharpestFold fold = sharpest_fold(mesh, std::vector<char>(4, 0));
    EXPECT_NEAR(fold.angle_degrees, degrees, 1e-9);
    if (degrees > 0.0) {
      EXPECT_LT(distance(fold.place, {0.5, 0, 0}), 1e-12);
    }
    EXPECT_EQ(sharpest_fold(mesh, {1, 0, 0, 0}).angle_degrees, 0.0);
  }
}

}  // namespace
}  // namespace angio::simulation

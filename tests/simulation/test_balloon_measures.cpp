#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "simulation/balloon_measures.hpp"
#include "simulation/pressed_wall.hpp"
#include "testing/simulation/models.hpp"

namespace angio::simulation {
namespace {

TEST(Dogboning, IsHowMuchWiderTheWiderEndIs) {
  SimulationFrame frame;
  frame.balloon_diameter_mm = 1.8;
  EXPECT_TRUE(std::isnan(dogboning_percent(frame))) << "no ends are watched";
  frame.end_diameters_mm = {2.7, 3.0};
  EXPECT_NEAR(dogboning_percent(frame), 40.0, 1e-12);
  frame.end_diameters_mm = {3.6, 3.0};
  EXPECT_NEAR(dogboning_percent(frame), 50.0, 1e-12);
  frame.balloon_diameter_mm = 3.6;
  EXPECT_NEAR(dogboning_percent(frame), 0.0, 1e-12);
}

TEST(Dogboning, OfABalloonInAStenosisIsSeenByTheSolver) {
  SimulationModel model = testing::make_model({.wall_rings = 31});
  model.balloon_ends = {{{0, 0, -4.0}, {0, 0, 1}}, {{0, 0, 4.0}, {0, 0, 1}}};
  SimulationOptions options;
  options.inflation.peak_pressure_atm = 2.0;
  options.inflation.inflate_s = 0.2;
  options.inflation.hold_s = 0.05;
  options.inflation.deflate_s = 0.05;
  options.inflation.rest_s = 0.0;
  SimulationFrame peak;
  simulate(model, options, [&](const SimulationFrame& frame) {
    if (frame.phase == Phase::hold) peak = frame;
  });
  ASSERT_EQ(peak.end_diameters_mm.size(), 2U);
  // What the balloon's own vertices say there: the model has a ring every half millimetre.
  const auto diameter_near = [&](double z) {
    double area = 0.0;
    int count = 0;
    for (const Vec3& p : peak.balloon)
      if (std::abs(p.z - z) < 0.3) {
        area += units::kPi * (p.x * p.x + p.y * p.y);
        ++count;
      }
    return 2.0 * std::sqrt(area / count / units::kPi);
  };
  EXPECT_NEAR(peak.end_diameters_mm[0], diameter_near(-4.0), 0.05);
  EXPECT_NEAR(peak.end_diameters_mm[1], diameter_near(4.0), 0.05);
  EXPECT_GT(dogboning_percent(peak), 5.0) << "the stenosis holds the balloon's middle";
}

TEST(ContactPressure, QuantilesAreByTheAreaThatIsPressed) {
  // Squares of 1 and of 2 mm and one that nothing presses, each of two triangles.
  SimulationFrame frame;
  std::vector<Triangle> triangles;
  const auto add_square = [&](double edge, double kpa) {
    const int first = int(frame.wall.size());
    for (const Vec3& corner : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 1, 0}, Vec3{0, 1, 0}}) {
      frame.wall.push_back(Vec3{10.0 * first, 0, 0} + edge * corner);
      frame.contact_pressure_kpa.push_back(kpa);
    }
    triangles.push_back({first, first + 1, first + 2});
    triangles.push_back({first, first + 2, first + 3});
  };
  add_square(1.0, 900.0);
  add_square(2.0, 200.0);
  add_square(9.0, 0.0);
  const auto pressure = contact_pressure(triangles, frame);
  ASSERT_TRUE(pressure);
  EXPECT_EQ(pressure->median_kpa, 200.0) << "four fifths of the area";
  EXPECT_EQ(pressure->p99_kpa, 900.0);
  frame.contact_pressure_kpa.assign(frame.wall.size(), 0.0);
  EXPECT_FALSE(contact_pressure(triangles, frame));
}

/// A tube about z of [-10, 10] mm, radius 1.5 mm, pressed where |z| < `half` by
/// 200 kPa (1 + cos(2 angle) / 2), each row of vertices by its share of that, and by 1 kPa for one
/// more row, which a coarse mesh's contact feels, too.
SimulationFrame pressed_tube(int around, double half, std::vector<Triangle>& triangles) {
  constexpr double kRadius = 1.5;
  const double edge = 2.0 * units::kPi * kRadius / around;
  const int rows = 2 * int(10.0 / edge) + 1;
  SimulationFrame frame;
  frame.balloon_diameter_mm = 2.0 * kRadius;
  frame.pressure_atm = 8.0;
  const auto at = [&](int row, int k) { return row * around + k % around; };
  for (int row = 0; row < rows; ++row)
    for (int k = 0; k < around; ++k) {
      const double angle = 2.0 * units::kPi * (k + 0.5 * (row % 2)) / around,
                   z = edge * (row - rows / 2);
      frame.wall.push_back({kRadius * std::cos(angle), kRadius * std::sin(angle), z});
      const double pressure = 200.0 * (1.0 + 0.5 * std::cos(2.0 * angle));
      const double share = std::clamp((half - std::abs(z)) / edge + 0.5, 0.0, 1.0);
      frame.contact_pressure_kpa.push_back(share > 0.0                 ? share * pressure
                                           : std::abs(z) < half + edge ? 1.0
                                                                       : 0.0);
      if (row + 1 == rows) continue;
      triangles.push_back({at(row, k), at(row, k + 1), at(row + 1, k)});
      triangles.push_back({at(row, k + 1), at(row + 1, k + 1), at(row + 1, k)});
    }
  return frame;
}

TEST(PressedWall, ConvergesToWhatPressesIt) {
  constexpr double kHalf = 4.03;
  const double area = 2.0 * units::kPi * 1.5 * 2.0 * kHalf;
  for (const int around : {16, 24, 48}) {
    std::vector<Triangle> triangles;
    const SimulationFrame frame = pressed_tube(around, kHalf, triangles);
    const PressedWall pressed = pressed_wall(triangles, frame);
    EXPECT_NEAR(pressed.force_n, 1e-3 * 200.0 * area, 0.06 * 0.2 * area) << around;
    // A disc that the edge cuts counts until a twentieth of 811 kPa is left of its mean.
    EXPECT_GT(pressed.area_mm2, 0.98 * area) << around;
    EXPECT_LT(pressed.area_mm2, 1.1 * area) << around;
    EXPECT_NEAR(pressed.median_kpa, 190.0, 15.0) << around;
    EXPECT_NEAR(pressed.p99_kpa, 290.0, 12.0) << around;
  }
}

TEST(PressedWall, OneVertexDoesNotDecide) {
  std::vector<Triangle> triangles;
  SimulationFrame frame = pressed_tube(48, 4.03, triangles);
  const double before = pressed_wall(triangles, frame).p99_kpa;
  const std::size_t one = frame.wall.size() / 2;
  frame.contact_pressure_kpa[one] *= 20.0;
  const PressedWall pressed = pressed_wall(triangles, frame);
  EXPECT_LT(pressed.p99_kpa, 2.0 * before);
  EXPECT_LT(*std::max_element(pressed.pressure_kpa.begin(), pressed.pressure_kpa.end()),
            0.25 * frame.contact_pressure_kpa[one]);
}

TEST(PressedWall, IsEmptyWhereNothingPresses) {
  std::vector<Triangle> triangles;
  SimulationFrame frame = pressed_tube(16, -0.4, triangles);
  const PressedWall pressed = pressed_wall(triangles, frame);
  EXPECT_EQ(pressed.area_mm2, 0.0) << "1 kPa is under a twentieth of 811";
  EXPECT_TRUE(std::isnan(pressed.median_kpa));
}

}  // namespace
}  // namespace angio::simulation

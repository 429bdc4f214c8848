#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "simulation/balloon_measures.hpp"
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

}  // namespace
}  // namespace angio::simulation

#include <gtest/gtest.h>

#include "testing/simulation/pushed.hpp"

/// A balloon led through a lumen.
namespace angio::simulation {
namespace {

constexpr double kDegree = units::kPi / 180.0;

TEST(Motion, ABalloonThatClearsTheWallTurnsAndSlidesAsInFreeSpace) {
  testing::Screw screw;
  screw.turn = 2.0 * kDegree;
  screw.shift = 0.03;
  screw.frames = 40;
  const double stray = testing::hindrance(testing::loose_balloon(0.875, 1.0),
                                          testing::led_options(screw.frames * 0.025), screw);
  EXPECT_LT(stray, 0.01);
}

TEST(Motion, APressedBalloonThatIsTurnedHasNoFalseContacts) {
  const SimulationModel model = testing::loose_balloon(0.875, 1.0);
  SimulationOptions options = testing::led_options(20 * 0.025);
  options.balloon.name = "polyurethane";
  options.inflation.peak_pressure_atm = 2.0;
  options.inflation.inflate_s = 0.25;
  options.contact.friction_static = options.contact.friction_kinetic =
      options.contact.adhesion_traction_kpa = 0.0;
  testing::Screw screw;
  screw.turn = 4.0 * kDegree;
  screw.from_frame = 11;
  screw.frames = 15;
  const testing::Led led = testing::lead(model, options, screw);
  testing::ContactCheck check;
  for (std::size_t f = 15; f < 26; f += 5) testing::check_contact(model, led.frames[f], check);
  EXPECT_GT(check.active, 100);
  EXPECT_EQ(check.false_ones, 0);
  EXPECT_GT(check.least_gap, 5e-4);
}

}  // namespace
}  // namespace angio::simulation

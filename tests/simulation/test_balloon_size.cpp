#include <gtest/gtest.h>

#include "core/units.hpp"
#include "simulation/balloon_size.hpp"
#include "simulation/inflate.hpp"

namespace angio::simulation {
namespace {

// The hoop stress of a thin tube at its rated pressure [MPa].
double rated_stress(double diameter) {
  const BalloonSize size = balloon_size(diameter);
  return 1e-6 * units::pascal_from_atm(size.rated_burst_atm) * diameter / (2.0 * size.wall_mm);
}

TEST(BalloonSize, UpToFourMillimetresIsTheCoronaryOne) {
  const SimulationOptions coronary;
  EXPECT_DOUBLE_EQ(balloon_size(3.0).wall_mm, coronary.balloon.wall_mm);
  for (const double diameter : {1.0, 2.5, 4.0}) {
    EXPECT_EQ(balloon_size(diameter).nominal_pressure_atm, coronary.inflation.peak_pressure_atm);
  }
}

TEST(BalloonSize, HasTheSameHoopStressWhenRatedAboveThat) {
  for (const double diameter : {5.0, 8.0, 12.0, 18.0, 30.0})
    EXPECT_NEAR(rated_stress(diameter), rated_stress(4.0), 1e-9 * rated_stress(4.0));
  EXPECT_LT(rated_stress(30.0), 241.0);  // what thin balloon walls hold (EP 0274411)
}

TEST(BalloonSize, IsNearMeasuredValvuloplastyBalloons) {
  // 20 to 28 mm: nominal 3 atm, rated 6 atm (doi 10.1002/ccd.28503).
  EXPECT_NEAR(balloon_size(24.0).nominal_pressure_atm, 3.0, 0.5);
  EXPECT_NEAR(balloon_size(24.0).rated_burst_atm, 6.0, 0.5);
  for (const double diameter : {0.6, 3.0, 12.0, 30.0})
    EXPECT_LT(balloon_size(diameter).nominal_pressure_atm, balloon_size(diameter).rated_burst_atm);
}

TEST(BalloonSize, HasItsNominalDiameterAtItsNominalPressure) {
  for (const double diameter : {0.6, 1.5, 2.25, 3.0, 4.0, 7.0, 16.0, 30.0}) {
    const BalloonSize size = balloon_size(diameter);
    EXPECT_NO_THROW(validate_chart(size.chart, "usual"));
    EXPECT_NEAR(chart_diameter_mm(size.chart, size.nominal_pressure_atm), diameter,
                1e-12 * diameter);
    EXPECT_NEAR(size.chart.back().pressure_atm, size.rated_burst_atm, 1e-12);
  }
}

// By Newton's method, in equilibrium: the membrane follows the chart within 0.5 %, whatever its
// size.
TEST(BalloonSize, AloneAtItsNominalPressureItHasItsNominalDiameter) {
  for (const double diameter : {1.25, 3.0, 3.75, 9.0}) {
    const BalloonSize size = balloon_size(diameter);
    FreeBalloon balloon;
    balloon.radius_mm = 0.5 * rest_diameter_mm(size.chart);
    balloon.length_mm = 4.0 * diameter;
    balloon.material.wall_mm = size.wall_mm;
    balloon.material.chart = size.chart;
    InflateOptions options;
    options.pressures_atm = {size.nominal_pressure_atm, size.rated_burst_atm};
    const auto points = inflate(balloon, options);
    EXPECT_NEAR(points[0].diameter_mm / diameter, 1.0, 0.005);
    EXPECT_NEAR(points[1].diameter_mm / size.chart.back().diameter_mm, 1.0, 0.005);
  }
}

TEST(Sized, FillsInWhatIsLeftToTheSizeAndNothingElse) {
  SimulationOptions given = options_by_size();
  given.balloon.wall_mm = 0.033;
  given.contact.adhesion_traction_kpa = 0.0;
  const SimulationOptions options = sized(given, 16.0);
  EXPECT_EQ(options.balloon.wall_mm, 0.033);
  EXPECT_EQ(options.contact.adhesion_traction_kpa, 0.0);
  EXPECT_NEAR(options.inflation.peak_pressure_atm, 4.0, 1e-12);
  EXPECT_NEAR(options.contact.distance_mm, 4.0 * SimulationOptions{}.contact.distance_mm, 1e-12);
}

TEST(Sized, IsTheDefaultsForACoronaryBalloon) {
  const SimulationOptions options = sized(options_by_size(), 3.0), coronary;
  EXPECT_DOUBLE_EQ(options.balloon.wall_mm, coronary.balloon.wall_mm);
  EXPECT_EQ(options.inflation.peak_pressure_atm, coronary.inflation.peak_pressure_atm);
  EXPECT_EQ(options.contact.distance_mm, coronary.contact.distance_mm);
  EXPECT_EQ(options.contact.adhesion_traction_kpa, coronary.contact.adhesion_traction_kpa);
  EXPECT_EQ(options.contact.adhesion_gap_1_mm, coronary.contact.adhesion_gap_1_mm);
  EXPECT_EQ(options.contact.adhesion_gap_2_mm, coronary.contact.adhesion_gap_2_mm);
}

TEST(Sized, IsValidForEveryBalloonThatIsSold) {
  for (double diameter = 0.5; diameter <= 30.0; diameter += 0.25)
    EXPECT_NO_THROW(sized(options_by_size(), diameter).validate()) << diameter;
}

}  // namespace
}  // namespace angio::simulation

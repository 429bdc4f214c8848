#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/orbit.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction::detail {
namespace {

using tests::turn;

TEST(Orbit, OfACArmIsItsCircle) {
  const Orbit orbit = fit_orbit(turn(50, -100.0, 90.0));
  EXPECT_NEAR(std::abs(orbit.axis.z), 1.0, 1e-12);
  EXPECT_LT(norm(orbit.isocentre), 1e-6);
  for (const double radius : orbit.radius) EXPECT_NEAR(radius, 800.0, 1e-6);
  EXPECT_NEAR(orbit.arc() * 180.0 / units::kPi, 190.0 * 50.0 / 49.0, 1e-9);
}

TEST(Orbit, SharesItsArcAmongItsFramesInWhateverOrder) {
  auto frames = turn(30, -95.0, 95.0);
  std::swap(frames[3], frames[17]);
  const Orbit orbit = fit_orbit(frames);
  double sum = 0.0;
  for (const double step : orbit.step) sum += step;
  EXPECT_NEAR(sum, orbit.arc(), 1e-12);
}

TEST(Orbit, GoesThroughTheHalfTurnWithoutAJump) {
  EXPECT_NEAR(fit_orbit(turn(100, 60.0, 250.0)).largest_step * 180.0 / units::kPi, 190.0 / 99.0,
              1e-9);
}

TEST(Orbit, OfARollIsAroundThePatientsSideAxis) {
  std::vector<angiogram::ConeBeamFrame> frames;
  for (int f = 0; f < 20; ++f) {
    angiogram::CArmMount mount;
    mount.columns = mount.rows = 32;
    mount.central_column = mount.central_row = 15.5;
    frames.push_back(angiogram::c_arm_frame({0.0, -80.0 + 8.0 * f}, mount));
  }
  EXPECT_NEAR(std::abs(fit_orbit(frames).axis.x), 1.0, 1e-12);
}

TEST(Orbit, OfStillFramesOrASmallArcIsRefused) {
  EXPECT_THROW(fit_orbit(turn(20, 30.0, 30.0)), InputError);
  EXPECT_THROW(fit_orbit(turn(20, 0.0, 35.0)), InputError);
  EXPECT_THROW(fit_orbit(turn(2, 0.0, 90.0)), InputError);
}

}  // namespace
}  // namespace angio::reconstruction::detail

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "angiogram/c_arm.hpp"
#include "core/units.hpp"

namespace angio::angiogram {
namespace {

void expect_near(const Vec3& a, const Vec3& b) { EXPECT_LT(distance(a, b), 1e-12); }

TEST(CArm, StandsAsDicomSaysIt) {
  expect_near(c_arm_axes({0, 0}).to_detector, {0, -1, 0});    // in front of the chest
  expect_near(c_arm_axes({90, 0}).to_detector, {1, 0, 0});    // at the left hand
  expect_near(c_arm_axes({-90, 0}).to_detector, {-1, 0, 0});  // at the right hand
  expect_near(c_arm_axes({0, 90}).to_detector, {0, 0, 1});    // at the head
  expect_near(c_arm_axes({0, -90}).to_detector, {0, 0, -1});  // at the feet
}

TEST(CArm, FromInFrontThePatientsLeftIsAtTheRightAndTheHeadUp) {
  expect_near(c_arm_axes({0, 0}).right, {1, 0, 0});
  expect_near(c_arm_axes({0, 0}).up, {0, 0, 1});
  expect_near(c_arm_axes({90, 0}).right, {0, 1, 0});  // from the left: the back is at the right
}

TEST(CArm, AxesAreRightHandedAndItsBeamIsAsFarFromTheFrontAsDicomSays) {
  for (const double p : {-170.0, -60.0, -1.0, 0.0, 33.0, 90.0})
    for (const double s : {-80.0, -25.0, 0.0, 40.0, 90.0}) {
      const CArmAxes axes = c_arm_axes({p, s});
      expect_near(cross(axes.right, axes.up), axes.to_detector);
      EXPECT_NEAR(norm(axes.up), 1.0, 1e-12);
      EXPECT_NEAR(dot(axes.right, axes.up), 0.0, 1e-12);
      const double rad = units::kPi / 180.0;
      EXPECT_NEAR(std::cos(rad * angle_between({p, s}, {})), std::cos(p * rad) * std::cos(s * rad),
                  1e-9);
    }
}

TEST(CArm, AnglesComeBackFromTheDirection) {
  for (const double p : {-170.0, -60.0, 0.0, 33.0})
    for (const double s : {-80.0, 0.0, 40.0}) {
      const CArmAngles angles = c_arm_angles(3.0 * c_arm_axes({p, s}).to_detector);
      EXPECT_NEAR(angles.primary_degrees, p, 1e-9);
      EXPECT_NEAR(angles.secondary_degrees, s, 1e-9);
    }
  EXPECT_EQ(c_arm_angles({0, 0, 1}).primary_degrees, 0.0);
}

TEST(CArm, IsNamedAsInACatheterLaboratory) {
  EXPECT_EQ(c_arm_label({32, 15}), "LAO 32 CRA 15");
  EXPECT_EQ(c_arm_label({-30.4, -0.4}), "RAO 30");
  EXPECT_EQ(c_arm_label({0, -20}), "AP CAU 20");
  EXPECT_EQ(c_arm_label({}), "AP");
}

TEST(CArm, BeamsFromEitherEndShowTheSameDepth) {
  for (const double degrees : {0.0, 20.0, 60.0, 90.0, 120.0, 180.0}) {
    const Vec3 a = 700.0 * c_arm_axes({10.0, 20.0}).to_detector,
               b = 3.0 * c_arm_axes({10.0, 20.0 - degrees}).to_detector;
    const double depth = std::min(degrees, 180.0 - degrees);
    EXPECT_NEAR(angle_between_beams(a, b), depth, 1e-5);
    EXPECT_NEAR(angle_between_beams(-1.0 * a, b), depth, 1e-5);
  }
}

}  // namespace
}  // namespace angio::angiogram

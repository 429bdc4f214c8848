#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "segmentation/detail/hessian.hpp"
#include "segmentation/detail/vesselness.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation::detail {
namespace {

TEST(SymmetricEigenvalues, SatisfyTraceDeterminantAndOrder) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-2.0f, 2.0f);
  for (int trial = 0; trial < 1000; ++trial) {
    const float a = uniform(random), b = uniform(random), c = uniform(random), d = uniform(random),
                e = uniform(random), f = uniform(random);
    const auto l = symmetric_eigenvalues(a, b, c, d, e, f);
    EXPECT_LE(l.x, l.y + 1e-4f);
    EXPECT_LE(l.y, l.z + 1e-4f);
    EXPECT_NEAR(l.x + l.y + l.z, a + b + c, 1e-4f);
    const float determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e);
    EXPECT_NEAR(l.x * l.y * l.z, determinant, 2e-3f);
  }
}

TEST(SymmetricEigenvalues, OfAMultipleOfTheIdentityAreEqual) {
  const auto l = symmetric_eigenvalues(2, 2, 2, 0, 0, 0);
  EXPECT_FLOAT_EQ(l.x, 2.0f);
  EXPECT_FLOAT_EQ(l.z, 2.0f);
}

TEST(TubeContrast, OnTheAxisOfATubeFollowsTheClosedForm) {
  const double radius = 1.5;
  TubeImage image{{60, 60, 60}, {0.25, 0.25, 0.25}, 400, 40, 0.1};
  const auto volume = image_of(image, [&](const Vec3& p) { return along_z(p, radius); });
  for (double scale_radius : {1.5, 2.0, 3.0}) {
    const double x = radius * radius / (scale_radius * scale_radius);  // r^2 / (2 s^2)
    const double expected = 360.0 * std::numbers::e * x * std::exp(-x);
    const auto contrast = tube_contrast(volume, {scale_radius}, {});
    EXPECT_NEAR(double(contrast.at(30, 30, 30)), expected, 0.1 * expected) << scale_radius;
  }
}

TEST(TubeContrast, OfATubeAlongThickSlicesFollowsTheSameForm) {
  const double radius = 1.5;
  TubeImage image{{60, 60, 16}, {0.25, 0.25, 3.0}, 400, 40, 0.1};
  const auto volume = image_of(image, [&](const Vec3& p) { return along_z(p, radius); });
  for (double scale_radius : {1.0, 1.5, 2.0}) {
    const double x = radius * radius / (scale_radius * scale_radius);
    const double expected = 360.0 * std::numbers::e * x * std::exp(-x);
    const auto contrast = tube_contrast(volume, {scale_radius}, {});
    EXPECT_NEAR(double(contrast.at(30, 30, 8)), expected, 0.1 * expected) << scale_radius;
  }
}

TEST(TubeContrast, IsNothingOnAPlateOrInAConstantVolume) {
  TubeImage image{{40, 40, 40}, {0.3, 0.3, 0.3}, 400, 40, 0.15};
  const auto plate = image_of(image, [](const Vec3& p) { return std::abs(p.x) - 1.0; });
  for (float c : tube_contrast(plate, {0.5, 1.0, 2.0}, {}).values) EXPECT_LT(c, 4.0f);
  const auto constant = image_of(image, [](const Vec3&) { return 100.0; });
  for (float c : tube_contrast(constant, {0.5, 1.0, 2.0}, {}).values) EXPECT_EQ(c, 0.0f);
}

}  // namespace
}  // namespace angio::segmentation::detail

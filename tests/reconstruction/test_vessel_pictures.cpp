#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "reconstruction/detail/vessel_pictures.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr int kColumns = 140, kRows = 110;
constexpr double kWidest = 30.0;  ///< [pixels]

/// A body, a vessel of a radius across it, and noise.
std::vector<float> picture(double vessel_radius, double noise, bool has_bone = false) {
  std::mt19937 engine(7);
  std::normal_distribution<double> numbers;
  std::vector<float> pixels;
  for (int r = 0; r < kRows; ++r)
    for (int c = 0; c < kColumns; ++c) {
      const double x = c - 60.0, y = r - 50.0, from_axis = 0.8 * x - 0.6 * y;
      double value = 3.0 - 1e-4 * x * x - 2e-4 * y * y + 0.002 * y;
      value +=
          0.04 * std::sqrt(std::max(0.0, vessel_radius * vessel_radius - from_axis * from_axis));
      if (has_bone && std::hypot(c - 100.0, r - 70.0) < 28.0) value += 0.8;
      pixels.push_back(float(value + noise * numbers(engine)));
    }
  return pixels;
}

/// The vessel's line integrals summed across it, about its middle, to both sides [pixels].
double across(const VesselPicture& picture) {
  double sum = 0.0;
  int lines = 0;
  for (int along = -15; along <= 15; ++along, ++lines)
    for (double t = -14.0; t <= 14.0; t += 1.0) {
      const int c = int(std::lround(60.0 + 0.8 * t + 0.6 * along)),
                r = int(std::lround(50.0 - 0.6 * t + 0.8 * along));
      sum += double(picture.line_integrals[std::size_t(r) * kColumns + std::size_t(c)]);
    }
  return sum / lines;
}

TEST(VesselPictures, HoldTheVesselAndNoTissue) {
  for (const double radius : {2.0, 5.0}) {
    const VesselPicture found = vessels_of(picture(radius, 0.01), kColumns, kRows, kWidest, false);
    EXPECT_NEAR(found.noise, 0.01, 0.001);
    const double expected = 0.02 * M_PI * radius * radius;  // of the half circle
    EXPECT_NEAR(across(found), expected, 0.05 * expected + 0.02) << radius;
    EXPECT_TRUE(found.is_vessel[50 * kColumns + 60]);
    EXPECT_FALSE(found.is_vessel[20 * kColumns + 20]);
  }
}

TEST(VesselPictures, TakeBoneForBackground) {
  const VesselPicture found = vessels_of(picture(3.0, 0.01, true), kColumns, kRows, kWidest, false);
  EXPECT_NEAR(found.line_integrals[70 * kColumns + 100], 0.0, 0.2);  // of 0.8
  EXPECT_TRUE(found.is_vessel[50 * kColumns + 60]);
}

TEST(VesselPictures, OfASubtractedFrameAreTheFrame) {
  const std::vector<float> given = picture(3.0, 0.01);
  EXPECT_EQ(vessels_of(given, kColumns, kRows, kWidest, true).line_integrals, given);
}

}  // namespace
}  // namespace angio::reconstruction::detail

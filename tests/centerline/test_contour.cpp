#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "centerline/detail/contour.hpp"
#include "core/units.hpp"

// What is measured on a section: against closed forms.
namespace angio::centerline {
namespace {

constexpr double kTurn = 0.6;  // [rad]

/// A rectangle of width x height around a middle, turned by kTurn.
Contour rectangle(double width, double height, const Point2& middle, int per_side = 1) {
  const Point2 corners[] = {{-0.5 * width, -0.5 * height},
                            {0.5 * width, -0.5 * height},
                            {0.5 * width, 0.5 * height},
                            {-0.5 * width, 0.5 * height}};
  Contour contour;
  for (int c = 0; c < 4; ++c)
    for (int n = 0; n < per_side; ++n) {
      const double t = double(n) / per_side;
      const Point2 &a = corners[c], &b = corners[(c + 1) % 4];
      const double x = a.x + t * (b.x - a.x), y = a.y + t * (b.y - a.y);
      contour.push_back({middle.x + std::cos(kTurn) * x - std::sin(kTurn) * y,
                         middle.y + std::sin(kTurn) * x + std::cos(kTurn) * y});
    }
  return contour;
}

Contour ellipse(double a, double b, const Point2& middle, int count = 180) {
  Contour contour;
  for (int n = 0; n < count; ++n) {
    const double angle = 2.0 * units::kPi * n / count;
    contour.push_back({middle.x + a * std::cos(angle), middle.y + b * std::sin(angle)});
  }
  return contour;
}

double distance_to(const Contour& contour, const Point2& p) {
  double least = 1e300;
  for (const Point2& q : contour) least = std::min(least, std::hypot(p.x - q.x, p.y - q.y));
  return least;
}

TEST(Contour, MomentsOfATurnedRectangle) {
  const ContourMoments moments = contour_moments(rectangle(6.0, 2.0, {0.7, -1.1}));
  const double cosine = std::cos(kTurn), sine = std::sin(kTurn);
  EXPECT_NEAR(moments.area, 12.0, 1e-12);
  EXPECT_NEAR(moments.middle.x, 0.7, 1e-12);
  EXPECT_NEAR(moments.middle.y, -1.1, 1e-12);
  EXPECT_NEAR(moments.xx, cosine * cosine * 3.0 + sine * sine / 3.0, 1e-12);
  EXPECT_NEAR(moments.yy, sine * sine * 3.0 + cosine * cosine / 3.0, 1e-12);
  EXPECT_NEAR(moments.xy, cosine * sine * (3.0 - 1.0 / 3.0), 1e-12);
}

TEST(Contour, OfAnEmptyOrTurnedRoundOneHasNoArea) {
  Contour contour = rectangle(2.0, 1.0, {});
  std::reverse(contour.begin(), contour.end());
  EXPECT_EQ(contour_moments(contour).area, 0.0);
  EXPECT_EQ(contour_moments({}).area, 0.0);
}

TEST(Contour, TheLargestCircleTouchesTheLongSides) {
  const Contour contour = rectangle(6.0, 2.0, {0.4, 0.5}, 200);
  const Circle free = largest_circle(contour, 10.0);
  EXPECT_NEAR(free.radius, 1.0, 0.01);
  EXPECT_NEAR(distance_to(contour, free.center), free.radius, 0.01);
  // Held near the origin it is the one there: the axis runs by at |0.5 cos - 0.4 sin|.
  const double off = 0.5 * std::cos(kTurn) - 0.4 * std::sin(kTurn);
  const Circle held = largest_circle(contour, 0.05);
  EXPECT_LE(std::hypot(held.center.x, held.center.y), 0.05 + 1e-12);
  EXPECT_NEAR(held.radius, 1.0 - (off - 0.05), 0.01);
}

TEST(Contour, TheMiddleIsTheCentroidAndInACrescentStaysInside) {
  const Contour flat = ellipse(4.0, 1.0, {0.3, 0.0});
  const Point2 middle = section_middle(flat, largest_circle(flat, 10.0), 10.0);
  EXPECT_NEAR(middle.x, 0.3, 0.01);
  EXPECT_NEAR(middle.y, 0.0, 0.01);
  // A crescent: half a ring of radii 3 and 5, whose centroid is outside of it.
  Contour crescent;
  for (int n = 0; n <= 90; ++n)
    crescent.push_back(
        {5.0 * std::cos(units::kPi * n / 90.0), 5.0 * std::sin(units::kPi * n / 90.0)});
  for (int n = 90; n >= 0; --n)
    crescent.push_back(
        {3.0 * std::cos(units::kPi * n / 90.0), 3.0 * std::sin(units::kPi * n / 90.0)});
  for (Point2& p : crescent) p.y -= 4.0;  // the origin is in its middle
  ASSERT_LT(contour_moments(crescent).middle.y + 4.0, 3.0);
  const Circle largest = largest_circle(crescent, 10.0);
  EXPECT_NEAR(largest.radius, 1.0, 0.01);
  const Point2 inside = section_middle(crescent, largest, 10.0);
  EXPECT_GE(distance_to(crescent, inside), 0.94 * largest.radius);
}

TEST(Contour, ErrorsOfAFlatWallAddToItsRadiiAndThoseOfACircleDoNot) {
  constexpr double kSd = 0.05;
  for (const double bias : polar_bias(ellipse(2.0, 2.0, {}), kSd)) EXPECT_NEAR(bias, 0.0, 1e-6);
  // A circle of radius R seen from its middle moved along x by e: in line with both, alpha = 0, and
  // 1 / r - k with r = R - e and R + e.
  constexpr double kRadius = 2.0, kOff = 0.5;
  const std::vector<double> bias = polar_bias(ellipse(kRadius, kRadius, {kOff, 0.0}, 720), kSd);
  EXPECT_NEAR(bias[0], kSd * kSd * (1.0 / (kRadius + kOff) - 1.0 / kRadius), 1e-6);
  EXPECT_NEAR(bias[360], kSd * kSd * (1.0 / (kRadius - kOff) - 1.0 / kRadius), 1e-6);
  // A flat wall at a distance of 1, at 45 degrees: sd^2 / (r cos^2 alpha).
  const Contour square = ellipse(1.0, 1.0, {}, 4);
  Contour wall;
  for (int n = -100; n <= 100; ++n) wall.push_back({1.0, 0.02 * n});
  wall.push_back({-1.0, 2.0});
  wall.push_back({-1.0, -2.0});
  EXPECT_NEAR(polar_bias(wall, kSd)[150], kSd * kSd / (std::sqrt(2.0) * 0.5), 1e-6);
  EXPECT_EQ(polar_bias(square, 0.0), std::vector<double>(4, 0.0));
}

}  // namespace
}  // namespace angio::centerline

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "centerline/detail/polyline.hpp"
#include "core/centerline.hpp"
#include "core/units.hpp"

// Lines as points with widths.
namespace angio::centerline {
namespace {

Polyline straight(double length, int count) {
  Polyline line;
  for (int i = 0; i < count; ++i) {
    const double s = length * i / (count - 1);
    line.push_back({0.0, 0.6 * s, 0.8 * s}, 1.0 + 0.1 * s);
  }
  return line;
}

Polyline arc(double radius, double degrees, int count) {
  Polyline line;
  for (int i = 0; i < count; ++i) {
    const double angle = degrees * units::kPi / 180.0 * i / (count - 1);
    line.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.0}, 0.5);
  }
  return line;
}

TEST(Polyline, IsResampledIntoEvenStepsNearestToThoseThatAreWished) {
  for (const int count : {2, 3, 7})
    for (const double step : {0.09, 0.3, 0.4, 0.6, 0.9, 1.4, 5.0}) {
      Polyline line = straight(1.0, count);
      resample(line, 0, [&](double) { return step; });
      const auto steps = std::max(1, int(std::ceil(1.0 / step - 0.5)));
      ASSERT_EQ(int(line.points.size()), steps + 1) << count << " points, " << step;
      for (int i = 0; i <= steps; ++i) {
        const double s = double(i) / steps;
        EXPECT_NEAR(norm(line.points[std::size_t(i)]), s, 1e-9);
        EXPECT_NEAR(line.radius[std::size_t(i)], 1.0 + 0.1 * s, 1e-9);
        EXPECT_NEAR(line.extent[std::size_t(i)], 1.0 + 0.1 * s, 1e-9);
      }
    }
}

TEST(Polyline, KeepsItsFixedPointsAndItsCourse) {
  const Polyline before = arc(5.0, 120.0, 31);
  Polyline line = before;
  resample(line, 8, [](double radius) { return 0.5 * radius; });
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(line.points[i], before.points[i]);
  EXPECT_EQ(line.points.back(), before.points.back());
  for (const Vec3& p : line.points) EXPECT_NEAR(norm(p), 5.0, 1e-3);
  for (std::size_t i = 8; i < line.points.size(); ++i)
    EXPECT_NEAR(distance(line.points[i], line.points[i - 1]), 0.25, 0.01);
}

TEST(Polyline, TangentsAreChords) {
  const Polyline line = arc(5.0, 90.0, 91);
  const std::vector<double> s = arc_length(line.points);
  const double reach = 10.0 * s[1];
  for (const std::size_t i : {std::size_t(10), std::size_t(45), std::size_t(80)}) {
    const Vec3 tangent = tangent_at(line, s, i, reach);
    EXPECT_NEAR(dot(tangent, line.points[i]), 0.0, 1e-9);  // even to both sides
    EXPECT_GT(cross(line.points[i], tangent).z, 0.0);
  }
  // At the end the chord is of the last stretch, to a whole point: turned back by half its angle.
  const Vec3 end = end_tangent(line, reach);
  EXPECT_NEAR(std::atan2(end.y, end.x), units::kPi - 0.5 * reach / 5.0, 0.6 * s[1] / 5.0);
  EXPECT_NEAR(direction_reach(line, 45), 0.5, 1e-12);
}

TEST(Polyline, ATubeIsTheConesBetweenItsSpheres) {
  const std::vector<Vec3> points{{0, 0, 0}, {0, 0, 4}, {0, 0, 4}, {3, 0, 4}};
  const std::vector<double> radius{1.0, 2.0, 2.0, 0.5};
  for (double z = 0.0; z <= 4.0; z += 0.25) {
    EXPECT_TRUE(inside_tube(points, radius, 0, {0.0, -(1.0 + 0.25 * z) + 1e-6, z}));
    EXPECT_FALSE(inside_tube(points, radius, 0, {0.0, -(1.0 + 0.25 * z) - 1e-6, z}) && z < 2.0);
  }
  EXPECT_TRUE(inside_tube(points, radius, 0, {0, 0, -0.9}));
  EXPECT_FALSE(inside_tube(points, radius, 0, {0, 0, -1.1}));
  EXPECT_FALSE(inside_tube(points, radius, 2, {0, 0, 0}));
  EXPECT_TRUE(inside_tube(points, radius, 2, {3, 0, 4.4}));
  EXPECT_FALSE(inside_tube(points, radius, 2, {3, 0, 4.6}));
}

TEST(Polyline, IsSmoothedBehindItsFixedPoints) {
  Polyline line = straight(10.0, 21);
  const Polyline even = line;
  smooth(line, 0, 5);  // what is straight and even stays
  for (std::size_t i = 0; i < line.points.size(); ++i)
    EXPECT_NEAR(distance(line.points[i], even.points[i]), 0.0, 1e-12);
  line.points[3].x = line.points[12].x = 1.0;
  line.radius[12] += 1.0;
  const Polyline bent = line;
  smooth(line, 5, 1);
  EXPECT_EQ(line.points[3], bent.points[3]);
  EXPECT_NEAR(line.points[12].x, 0.5, 1e-12);
  EXPECT_NEAR(line.points[11].x, 0.25, 1e-12);
  EXPECT_NEAR(line.radius[13], bent.radius[13] + 0.25, 1e-12);
  line = bent;
  smooth_widths(line, 5, 1);
  EXPECT_EQ(line.points[12], bent.points[12]);
  EXPECT_NEAR(line.radius[12], bent.radius[12] - 0.5, 1e-12);
}

TEST(Polyline, ABridgeLeavesAndArrivesAlongItsTangents) {
  const Vec3 from{0, 0, 0}, to{4, 0, 0}, up{0, 1, 0}, along{1, 0, 0};
  const std::vector<Vec3> points = bridge(from, up, to, along, 399);
  ASSERT_EQ(points.size(), 399U);
  EXPECT_GT(dot(normalized(points.front() - from), up), 0.999);
  EXPECT_GT(dot(normalized(to - points.back()), along), 0.999);
  // The middle of a cubic Hermite curve: half way, and an eighth of the difference of its tangents.
  const Vec3 middle = 0.5 * (from + to) + 4.0 / 8.0 * (up - along);
  EXPECT_NEAR(distance(points[199], middle), 0.0, 1e-12);
}

}  // namespace
}  // namespace angio::centerline

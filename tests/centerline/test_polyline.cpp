#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "centerline/detail/polyline.hpp"
#include "centerline/detail/skeleton.hpp"
#include "centerline/detail/smooth_curve.hpp"
#include "centerline/detail/tube_samples.hpp"
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
  EXPECT_NEAR(
      distance(tangent_at(line, s, 90, reach), normalized(line.points[90] - line.points[89])), 0.0,
      1e-9);
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

/// What smooth_curve says that it makes least, by its definition.
double objective(const std::vector<Vec3>& x, const Middles& middles, const std::vector<double>& l) {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i)
    sum += middles.weight[i] * norm_squared(x[i] - middles.center[i]);
  for (std::size_t i = 2; i + 1 < x.size(); ++i)
    sum += std::pow(l[i], 6) * norm_squared(x[i + 1] - 3.0 * x[i] + 3.0 * x[i - 1] - x[i - 2]);
  for (std::size_t i = 1; i + 1 < x.size(); ++i)
    sum += std::pow(0.3 * l[i], 4) * norm_squared(x[i + 1] - 2.0 * x[i] + x[i - 1]);
  return sum;
}

TEST(SmoothCurve, IsTheLeastOfItsObjective) {
  constexpr double kStep = 1e-3, kFarOff = 1e9;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at(-1.0, 1.0);
  for (const std::size_t fixed : {std::size_t(0), std::size_t(1), std::size_t(5)}) {
    const std::size_t count = 40;
    std::vector<Vec3> points(count);
    Middles middles{std::vector<Vec3>(count), std::vector<double>(count)};
    std::vector<double> stiffness(count);
    for (std::size_t i = 0; i < count; ++i) {
      points[i] = {double(i), at(random), at(random)};
      middles.center[i] = points[i] + Vec3{0.0, at(random), at(random)};
      middles.weight[i] = 0.6 + 0.4 * at(random);
      stiffness[i] = 1.5 + at(random);
    }
    std::vector<Vec3> curve =
        smooth_curve(points, middles, fixed, stiffness, std::vector<double>(count, kFarOff));
    for (std::size_t i = 0; i < fixed; ++i) EXPECT_EQ(curve[i], points[i]);
    for (std::size_t i = fixed; i < count; ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const double here = curve[i][axis];
        const auto value = [&](double moved) {
          curve[i][axis] = here + moved;
          return objective(curve, middles, stiffness);
        };
        const double slope = (value(kStep) - value(-kStep)) / (2.0 * kStep);
        curve[i][axis] = here;
        EXPECT_NEAR(slope, 0.0, 1e-6) << i << " of " << fixed;
      }
  }
}

TEST(LocalCurve, FollowsACubicUpToTheLinesEnds) {
  const auto cubic = [](double x) {
    return Vec3{0.3 * x - 0.02 * x * x * x, 0.5 - x, 0.1 * x * x};
  };
  Polyline line;
  std::vector<double> x;  // stands for the arc length
  for (int i = 0; i < 21; ++i) {
    x.push_back(0.2 * i + 0.05 * (i % 3));
    line.push_back(cubic(x.back()), 1.0);
  }
  for (const double reach : {0.01, 1.0})
    for (std::size_t i = reach < 0.1 ? 2 : 0; i < (reach < 0.1 ? 19 : 21); ++i) {
      const LocalCurve curve = fit_curve(line, x, i, reach);
      for (const double away : {-0.3, 0.0, 0.3})
        EXPECT_NEAR(distance(curve.at(away), cubic(x[i] + away)), 0.0, 1e-5) << i << ", " << reach;
      EXPECT_NEAR(curve.first, -x[i], 1e-12);
      EXPECT_NEAR(curve.last, x.back() - x[i], 1e-12);
      EXPECT_NEAR(dot(curve.u, curve.tangent(0.0)), 0.0, 1e-12);
      EXPECT_NEAR(norm(cross(curve.u, curve.v) - curve.tangent(0.0)), 0.0, 1e-12);
    }
}

TEST(EndOfCap, IsADiameterInsideATubesDome) {
  for (const double radius : {0.5, 1.0, 2.0, 4.0}) {
    std::vector<Vec3> points;
    std::vector<double> depth;
    for (int i = 0; i < 300; ++i) {
      points.push_back({0.1 * i, 0.0, 0.0});
      depth.push_back(std::min(radius, 0.1 * i));
    }
    EXPECT_NEAR(points[std::size_t(end_of_cap(points, depth))].x, 2.0 * radius, 0.11) << radius;
  }
}

TEST(SmoothCurve, KeepsBendsAndTakesZigzagsAway) {
  constexpr int kCount = 200;
  constexpr double kStep = 0.25, kBend = 5.0;  // mm
  std::vector<Vec3> circle;
  Middles middles;
  for (int i = 0; i < kCount; ++i) {
    const double angle = kStep * i / kBend;
    circle.push_back({kBend * std::cos(angle), kBend * std::sin(angle), 0.0});
    middles.center.push_back(circle.back() + Vec3{0.0, 0.0, i % 2 == 0 ? 0.05 : -0.05});
    middles.weight.push_back(1.0);
  }
  const std::vector<double> stiffness(kCount, 1.5), tolerance(kCount, 1.0);
  const auto curve = smooth_curve(circle, middles, 0, stiffness, tolerance);
  for (int i = 10; i + 10 < kCount; ++i) {
    EXPECT_NEAR(std::hypot(curve[std::size_t(i)].x, curve[std::size_t(i)].y), kBend, 1e-3);
    EXPECT_NEAR(curve[std::size_t(i)].z, 0.0, 1e-3);
  }
}

TEST(SmoothCurve, LeavesOutAMiddleThatLiesFarOff) {
  std::vector<Vec3> line;
  Middles middles;
  for (int i = 0; i < 60; ++i) {
    line.push_back({0.25 * i, 0.0, 0.0});
    middles.center.push_back(line.back());
    middles.weight.push_back(1.0);
  }
  middles.center[30].y = 2.0;
  const auto curve =
      smooth_curve(line, middles, 0, std::vector<double>(60, 1.5), std::vector<double>(60, 0.5));
  for (const Vec3& p : curve) EXPECT_NEAR(p.y, 0.0, 1e-3);
}

}  // namespace
}  // namespace angio::centerline

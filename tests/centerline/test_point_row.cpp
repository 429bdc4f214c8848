#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <vector>

#include "centerline/detail/point_row.hpp"

namespace angio::centerline {
namespace {

/// A walk that crosses itself, with points that stand still and jumps.
std::vector<Vec3> random_walk(std::mt19937& random, std::size_t count) {
  std::normal_distribution<double> step(0.0, 1.0);
  std::vector<Vec3> points;
  Vec3 at;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 7 != 3) at += Vec3{step(random), step(random), step(random)};
    if (i % 50 == 49) at = Vec3{20.0 * step(random), 0.0, 0.0};
    points.push_back(at);
  }
  return points;
}

TEST(PointRow, NearestIsTheFirstOfThoseThatNoOtherIsNearerThan) {
  std::mt19937 random(5);
  std::normal_distribution<double> place(0.0, 10.0);
  for (const std::size_t count : {1UL, 15UL, 16UL, 17UL, 400UL}) {
    const std::vector<Vec3> points = random_walk(random, count);
    const PointRow row(points);
    for (int sample = 0; sample < 300; ++sample) {
      const Vec3 at = sample % 4 == 0 ? points[std::size_t(sample) % count]
                                      : Vec3{place(random), place(random), place(random)};
      std::size_t nearest = 0;
      for (std::size_t i = 1; i < count; ++i)
        if (norm_squared(points[i] - at) < norm_squared(points[nearest] - at)) nearest = i;
      ASSERT_EQ(row.nearest(at), nearest) << count << " points";
    }
  }
}

}  // namespace
}  // namespace angio::centerline

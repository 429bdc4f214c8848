#include <gtest/gtest.h>

#include <cmath>

#include "segmentation/detail/signed_distance.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation::detail {
namespace {

/// A level with the shape's zero and a slope that is not one.
Volume<float> level_of(const TubeImage& image, const std::function<double(const Vec3&)>& d) {
  Volume<float> level = image_of(image, d);
  const auto& g = level.geometry;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i)
        level.at(i, j, k) = float(0.3 * d(g.lps_from_index({double(i), double(j), double(k)})));
  return level;
}

void expect_distance(const TubeImage& image, const std::function<double(const Vec3&)>& d,
                     double tolerance, double reach) {
  const auto distance = signed_distance(level_of(image, d), reach);
  for (int k = 3; k < image.size[2] - 3; ++k)
    for (int j = 3; j < image.size[1] - 3; ++j)
      for (int i = 3; i < image.size[0] - 3; ++i) {
        const Vec3 p = distance.geometry.lps_from_index({double(i), double(j), double(k)});
        ASSERT_NEAR(double(distance.at(i, j, k)), std::min(d(p), reach), tolerance)
            << i << ' ' << j << ' ' << k;
      }
}

TEST(SignedDistance, OfAnObliquePlaneOnAnisotropicVoxelsIsExactForFourVoxels) {
  const TubeImage image{{30, 30, 24}, {0.3, 0.3, 0.5}, 0.5, -0.5, 0.6};
  const Vec3 normal = normalized(Vec3{1.0, 0.6, -0.4});
  // The plane's closest points may lie beyond the grid, so only its middle is far from an edge.
  const auto distance =
      signed_distance(level_of(image, [&](const Vec3& p) { return dot(normal, p); }), 5.0);
  for (int k = 8; k < 16; ++k)
    for (int j = 10; j < 20; ++j)
      for (int i = 10; i < 20; ++i) {
        const Vec3 p = distance.geometry.lps_from_index({double(i), double(j), double(k)});
        EXPECT_NEAR(double(distance.at(i, j, k)), dot(normal, p),
                    std::abs(dot(normal, p)) < 1.9 ? 1e-3 : 0.02);  // within four voxels, beyond
      }
}

TEST(SignedDistance, OfASphereIsWithinHalfAVoxelEverywhere) {
  const TubeImage image{{48, 48, 48}, {0.25, 0.25, 0.25}, 0.5, -0.5, 0.2};
  expect_distance(
      image,
      [](const Vec3& p) {
        return norm(p - Vec3{0.1, 0.03, -0.06}) - 3.0;
      },
      0.125, 100.0);
}

TEST(SignedDistance, EndsAtItsReachOutside) {
  const TubeImage image{{40, 40, 12}, {0.25, 0.25, 0.25}, 0.5, -0.5, 0.2};
  const auto distance =
      signed_distance(level_of(image, [](const Vec3& p) { return along_z(p, 1.0); }), 1.5);
  const auto [low, high] = std::minmax_element(distance.values.begin(), distance.values.end());
  EXPECT_FLOAT_EQ(*high, 1.5f);
  EXPECT_NEAR(double(*low), -1.0, 0.18);  // no voxel lies on the axis
}

TEST(SignedDistance, HasTheLevelsSignEverywhere) {
  const TubeImage image{{30, 30, 30}, {0.3, 0.3, 0.3}, 0.5, -0.5, 0.2, 0.1};
  auto level = image_of(image, [](const Vec3& p) { return along_z(p, 1.5); });  // noisy
  for (float& v : level.values) v = -v;
  const auto distance = signed_distance(level, 5.0);
  for (std::size_t v = 0; v < level.values.size(); ++v) {
    ASSERT_TRUE(std::isfinite(distance.values[v]));
    ASSERT_EQ(distance.values[v] < 0.0f, level.values[v] < 0.0f);
  }
}

}  // namespace
}  // namespace angio::segmentation::detail

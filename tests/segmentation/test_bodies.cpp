#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "segmentation/detail/bodies.hpp"
#include "segmentation/detail/depth.hpp"
#include "tests/segmentation/grids.hpp"

// What is as bright as blood, parted at its necks.
namespace angio::segmentation {
namespace {

using namespace detail;
using test::for_each_voxel;
using test::grid_of;

TEST(Depth, IsTheWayToTheNearestVoxelOutside) {
  const VolumeGeometry grid = grid_of({14, 12, 9}, {0.7, 0.9, 2.5});
  Volume<std::uint8_t> mask(grid);
  std::mt19937 random(3);
  for (auto& value : mask.values) value = random() % 12 != 0;
  const Volume<float> depth = depth_in(mask);
  for_each_voxel(grid, [&](const Vec3& p, std::size_t v) {
    double nearest = 1e30;
    for_each_voxel(grid, [&](const Vec3& q, std::size_t w) {
      if (!mask.values[w]) nearest = std::min(nearest, distance(p, q));
    });
    EXPECT_NEAR(depth.values[v], mask.values[v] ? nearest : 0.0, 1e-4);
  });
}

TEST(FillHoles, FillsWhatASectionGoesAround) {
  const VolumeGeometry grid = grid_of({40, 40, 20}, {1.0, 1.0, 1.0});
  Volume<std::uint8_t> shell(grid), open(grid);
  for_each_voxel(grid, [&](const Vec3& p, std::size_t v) {
    const double r = std::hypot(p.x, p.y);
    shell.values[v] = r > 8.0 && r < 10.0;
    open.values[v] = shell.values[v] && p.x < 6.0;
  });
  const Volume<std::uint8_t> before = open, large = shell;
  fill_holes(shell, 300.0);
  fill_holes(open, 300.0);
  for_each_voxel(grid, [&](const Vec3& p, std::size_t v) {
    EXPECT_EQ(shell.values[v], std::hypot(p.x, p.y) < 10.0);
    EXPECT_EQ(open.values[v], before.values[v]);
  });
  Volume<std::uint8_t> too_large = large;
  fill_holes(too_large, 150.0);
  EXPECT_EQ(too_large.values, large.values);
}

/// Two balls of radius 10, 24 apart, and a bar between them.
Bodies balls_and_bar(double bar_radius) {
  const VolumeGeometry grid = grid_of({60, 30, 30}, {1.0, 1.0, 1.0});
  Volume<std::uint8_t> mask(grid);
  for_each_voxel(grid, [&](const Vec3& p, std::size_t v) {
    mask.values[v] = norm(p - Vec3{-12, 0, 0}) < 10.0 || norm(p - Vec3{12, 0, 0}) < 10.0 ||
                     (std::abs(p.x) < 12.0 && std::hypot(p.y, p.z) < bar_radius);
  });
  return part_into_bodies(depth_in(mask), 3.0, 0.75);
}

TEST(Bodies, ArePartedAtNecksOnly) {
  EXPECT_EQ(balls_and_bar(9.0).count(), 1);
  const Bodies two = balls_and_bar(5.0);
  const auto deep =
      std::count_if(two.depth_mm.begin(), two.depth_mm.end(), [](float d) { return d > 8.0f; });
  EXPECT_EQ(deep, 2);
}

TEST(Bodies, GoWithTheOneOnTheDeepestNeck) {
  Bodies bodies;
  bodies.depth_mm = {0.0f, 9.0f, 2.0f, 9.0f, 1.0f};
  bodies.necks = {{1, 2, 1.8f}, {2, 3, 1.2f}};  // 4 touches none
  std::vector<Tissue> tissues{Tissue::unknown, Tissue::blood, Tissue::unknown, Tissue::other,
                              Tissue::unknown};
  spread(bodies, tissues);
  EXPECT_EQ(tissues[2], Tissue::blood);
  EXPECT_EQ(tissues[3], Tissue::other);
  EXPECT_EQ(tissues[4], Tissue::unknown);
}

}  // namespace
}  // namespace angio::segmentation

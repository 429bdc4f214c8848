#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "meshing/calcium.hpp"

namespace angio::meshing {
namespace {

constexpr double kRadius = 1.5, kVoxel = 0.25;  // mm
constexpr float kBlood = 400.0F, kNoise = 40.0F, kTissue = 40.0F, kCalcium = 900.0F;

double radius_of(const Vec3& p) { return std::hypot(p.x, p.y); }

/// How deep a point of the wall lies in the calcified shell, a half ring around the lumen [mm];
/// negative outside.
double depth_in_calcium(const Vec3& p) {
  return std::min({2.3 - radius_of(p), p.x, 2.0 - std::abs(p.z)});
}

struct Scan {
  Volume<float> volume, level_set;
};

/// A straight vessel along z; beyond z = 6 its blood is brighter, as nearer to the catheter.
Scan make_scan(bool with_calcium) {
  VolumeGeometry grid;
  grid.size = {28, 28, 80};
  grid.spacing = {kVoxel, kVoxel, kVoxel};
  grid.origin = {-13.5 * kVoxel, -13.5 * kVoxel, -6.0};
  Scan scan{Volume<float>(grid), Volume<float>(grid)};
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0F, kNoise);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = grid.lps_from_index({double(i), double(j), double(k)});
        const bool calcified = with_calcium && depth_in_calcium(p) > 0.0;
        const float blood = p.z > 6.0 ? 2.0F * kCalcium : kBlood;
        scan.volume.at(i, j, k) = noise(random) + (radius_of(p) < kRadius ? blood
                                                   : calcified            ? kCalcium
                                                                          : kTissue);
        scan.level_set.at(i, j, k) = float(radius_of(p) - kRadius);
      }
  return scan;
}

/// Rings of wedges around the lumen from z = -4 to 4: plaque from 1.5 to 2.0 mm, media to 2.5 mm.
WallLayers make_wall() {
  constexpr int kAround = 32, kRings = 33;
  WallLayers wall;
  for (const double r : {1.5, 2.0, 2.5})
    for (int k = 0; k < kRings; ++k)
      for (int i = 0; i < kAround; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kAround;
        wall.vertices.push_back({r * std::cos(angle), r * std::sin(angle), -4.0 + 0.25 * k});
      }
  const int level = kAround * kRings;
  for (int l = 0; l < 2; ++l)
    for (int k = 0; k + 1 < kRings; ++k)
      for (int i = 0; i < kAround; ++i) {
        const int a = l * level + k * kAround + i, b = l * level + k * kAround + (i + 1) % kAround,
                  c = b + kAround, d = a + kAround;
        for (const auto& [p, q, r] : {std::array{a, b, c}, std::array{a, c, d}}) {
          wall.wedges.push_back({p, q, r, p + level, q + level, r + level});
          wall.tissue.push_back(l == 0 ? WallTissue::plaque : WallTissue::media);
        }
      }
  return wall;
}

Vec3 centre_of(const WallLayers& wall, std::size_t wedge) {
  Vec3 centre;
  for (const int v : wall.wedges[wedge]) centre += (1.0 / 6.0) * wall.vertices[std::size_t(v)];
  return centre;
}

TEST(Calcium, LevelIsTheBloodsBesideTheWall) {
  const Scan scan = make_scan(true);
  const auto level = measure_calcium_level(scan.volume, scan.level_set, make_wall());
  ASSERT_TRUE(level);
  EXPECT_NEAR(level->lumen, kBlood, 0.1 * kNoise);
  EXPECT_NEAR(level->deviation, kNoise, 0.1 * kNoise);
}

// As a segmentation leaves it: finer, and around the lumen alone.
TEST(Calcium, LevelNeedsNoLevelSetOnTheScansGrid) {
  const Scan scan = make_scan(true);
  VolumeGeometry grid = scan.volume.geometry;
  grid.spacing = 0.5 * grid.spacing;
  grid.origin += Vec3{4.3 * kVoxel, 4.1 * kVoxel, 1.2 * kVoxel};
  grid.size = {38, 39, 150};
  Volume<float> own(grid);
  for (std::size_t v = 0; v < own.values.size(); ++v) {
    const auto i = int(v % 38), j = int(v / 38 % 39), k = int(v / (38 * 39));
    own.values[v] =
        float(radius_of(grid.lps_from_index({double(i), double(j), double(k)})) - kRadius);
  }
  const auto level = measure_calcium_level(scan.volume, own, make_wall());
  ASSERT_TRUE(level);
  EXPECT_NEAR(level->lumen, kBlood, 0.1 * kNoise);
  EXPECT_NEAR(level->deviation, kNoise, 0.1 * kNoise);
}

TEST(Calcium, IsThePlaqueThatTheScanShowsBrighterThanTheBlood) {
  const Scan scan = make_scan(true);
  WallLayers wall = make_wall();
  const WallLayers before = wall;
  const double volume = mark_calcium(scan.volume, {kBlood, kNoise}, wall);
  int calcified = 0;
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    const double depth = depth_in_calcium(centre_of(wall, w));
    if (before.tissue[w] == WallTissue::media) {
      EXPECT_EQ(wall.tissue[w], WallTissue::media) << w;
    } else if (std::abs(depth) > kVoxel) {  // nearer it is a voxel's share
      EXPECT_EQ(wall.tissue[w], depth > 0.0 ? WallTissue::calcium : WallTissue::plaque) << w;
    }
    calcified += wall.tissue[w] == WallTissue::calcium ? 1 : 0;
  }
  // A half ring from 1.5 to 2.0 mm, 4 mm long, is 11 mm^3; its border is a voxel wide.
  EXPECT_GT(calcified, 0);
  EXPECT_NEAR(volume, 0.5 * std::numbers::pi * (4.0 - 2.25) * 4.0, 2.0);
}

TEST(Calcium, IsNotFoundInNoise) {
  const Scan scan = make_scan(false);
  WallLayers wall = make_wall();
  EXPECT_EQ(mark_calcium(scan.volume, {kBlood, kNoise}, wall), 0.0);
}

TEST(Calcium, IsNotJudgedWithoutEnoughBlood) {
  Scan scan = make_scan(true);
  for (float& value : scan.level_set.values) value += float(kRadius);
  EXPECT_FALSE(measure_calcium_level(scan.volume, scan.level_set, make_wall()));
}

}  // namespace
}  // namespace angio::meshing

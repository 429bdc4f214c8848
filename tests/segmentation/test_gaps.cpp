#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/units.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/gaps.hpp"
#include "segmentation/segmentation.hpp"
#include "tests/segmentation/grids.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation {
namespace {

using namespace detail;
using test::for_each_voxel;
using test::grid_of;

constexpr std::uint8_t kVessel = 2, kWay = 1;
constexpr double kTubeRadius = 1.6;  ///< [mm]

Volume<std::uint8_t> draw(const std::function<bool(const Vec3&)>& is_vessel) {
  const VolumeGeometry grid = grid_of({60, 60, 100}, {0.4, 0.4, 0.4});
  Volume<std::uint8_t> mask(grid);
  for_each_voxel(
      grid, [&](const Vec3& p, std::size_t v) { mask.values[v] = is_vessel(p) ? kVessel : 0; });
  return mask;
}

int piece_count(const Volume<std::uint8_t>& mask) {
  return label_components(mask, Connectivity::faces).count();
}

/// A vessel along z, cut over `gap` mm in its middle; behind the cut it lies `aside` mm aside.
Volume<std::uint8_t> cut_vessel(double gap, double aside = 0.0,
                                double radius_behind = kTubeRadius) {
  return draw([=](const Vec3& p) {
    if (std::abs(p.z) < 0.5 * gap) return false;
    return p.z < 0.0 ? std::hypot(p.x, p.y) < kTubeRadius
                     : std::hypot(p.x - aside, p.y) < radius_behind;
  });
}

bool joins(Volume<std::uint8_t> mask) {
  const int before = piece_count(mask);
  join_across_gaps(mask, kWay, 20.0);
  return piece_count(mask) == before - 1;
}

TEST(Gaps, AVesselThatIsCutIsJoined) {
  for (const double gap : {0.9, 2.0, 4.0}) EXPECT_TRUE(joins(cut_vessel(gap))) << gap;
  EXPECT_TRUE(joins(cut_vessel(3.0, 1.2)));
  EXPECT_FALSE(joins(cut_vessel(6.0)));
}

TEST(Gaps, TheWayIsThinAndOfItsOwnKind) {
  Volume<std::uint8_t> mask = cut_vessel(3.0);
  const Volume<std::uint8_t> before = mask;
  join_across_gaps(mask, kWay, 20.0);
  ASSERT_EQ(piece_count(mask), 1);
  std::size_t added = 0;
  for (std::size_t v = 0; v < mask.values.size(); ++v) {
    if (mask.values[v] == before.values[v]) continue;
    EXPECT_EQ(before.values[v], 0);
    EXPECT_EQ(mask.values[v], kWay);
    ++added;
  }
  EXPECT_LE(added, 10U);  // 3 mm of voxels of 0.4 mm
}

TEST(Gaps, VesselsThatPassAreNot) {
  // Side by side; crossing; one that ends at the flank of another.
  EXPECT_FALSE(joins(draw([](const Vec3& p) {
    return std::hypot(p.x, p.y) < kTubeRadius || std::hypot(p.x - 4.2, p.y) < kTubeRadius;
  })));
  EXPECT_FALSE(joins(draw([](const Vec3& p) {
    return std::hypot(p.x, p.y) < kTubeRadius || std::hypot(p.x - 4.2, p.z) < kTubeRadius;
  })));
  EXPECT_FALSE(joins(draw([](const Vec3& p) {
    return std::hypot(p.x, p.y) < kTubeRadius || (std::hypot(p.y, p.z) < kTubeRadius && p.x > 3.0);
  })));
}

TEST(Gaps, OneIsNotFarWiderThanTheOther) {
  EXPECT_TRUE(joins(cut_vessel(2.0, 0.0, 1.5 * kTubeRadius)));
  EXPECT_FALSE(joins(cut_vessel(2.0, 0.0, 3.0 * kTubeRadius)));
}

TEST(Gaps, CrumbsAreNot) {
  EXPECT_FALSE(joins(draw([](const Vec3& p) {
    return (std::hypot(p.x, p.y) < kTubeRadius && p.z < 0.0) ||
           distance(p, {0.0, 0.0, 3.0}) < kTubeRadius;
  })));
}

/// The same with a way where `is_way`; whether it is left.
bool is_left(const std::function<bool(const Vec3&)>& is_vessel,
             const std::function<bool(const Vec3&)>& is_way) {
  Volume<std::uint8_t> mask = draw(is_vessel);
  for_each_voxel(mask.geometry, [&](const Vec3& p, std::size_t v) {
    if (mask.values[v] == 0 && is_way(p)) mask.values[v] = kWay;
  });
  EXPECT_EQ(piece_count(mask), 1);
  part_passing_vessels(mask, kWay, 20.0);
  return piece_count(mask) == 1;
}

TEST(Gaps, AWayFromFlankToFlankIsNone) {
  const auto way = [](const Vec3& p) {
    return std::hypot(p.y, p.z) < 0.7 && p.x > 0.0 && p.x < 3.5;
  };
  EXPECT_FALSE(is_left(
      [](const Vec3& p) {  // crossing
        return std::hypot(p.x, p.y) < kTubeRadius || std::hypot(p.x - 4.2, p.z) < kTubeRadius;
      },
      way));
  EXPECT_FALSE(is_left(
      [](const Vec3& p) {  // side by side, nearest in their middle
        return std::hypot(p.x, p.y) < kTubeRadius ||
               std::hypot(p.x - 4.2 - 0.01 * p.z * p.z, p.y) < kTubeRadius;
      },
      way));
}

TEST(Gaps, AWayToABranchOrThroughAStenosisIsOne) {
  const auto trunk = [](const Vec3& p) { return std::hypot(p.x, p.y) < kTubeRadius; };
  for (const double degrees : {90.0, 60.0, 40.0}) {  // to the trunk
    const double angle = degrees * units::kPi / 180.0;
    const Vec3 axis{std::sin(angle), 0.0, std::cos(angle)};
    const auto branch = [=](const Vec3& p) {
      const double along = dot(p, axis);
      return along > 0.0 && norm(p - along * axis) < 1.0;
    };
    EXPECT_TRUE(is_left(
        [=](const Vec3& p) { return trunk(p) || (branch(p) && p.x > kTubeRadius + 1.0); }, branch))
        << degrees;
  }
  EXPECT_TRUE(is_left([=](const Vec3& p) { return trunk(p) && std::abs(p.z) > 1.0; },
                      [](const Vec3& p) { return std::hypot(p.x, p.y) < 0.5; }));
}

TEST(Gaps, AThroatThatNoVoxelShowsLeavesOneTree) {
  // 85 % over 12 mm of a vessel of 3.2 mm, in voxels of 0.4 mm: its throat holds a sixth of one.
  const auto radius = [](double z) {
    const double part = std::abs(z) < 6.0 ? 0.5 * (1.0 + std::cos(units::kPi * z / 6.0)) : 0.0;
    return kTubeRadius * (1.0 - 0.85 * part);
  };
  TubeImage image;
  image.size = {40, 40, 100};
  image.spacing = {0.4, 0.4, 0.4};
  image.blur_mm = 0.35;
  image.noise_sd = 18.0;
  image.lumen = 450.0;
  Volume<float> volume = image_of(image, [&](const Vec3& p) { return along_z(p, radius(p.z)); });
  // A throat under the blur: of a thin tube's light, what its section holds.
  for_each_voxel(volume.geometry, [&](const Vec3& p, std::size_t v) {
    const double r = radius(p.z), blur = image.blur_mm;
    if (r > 2.0 * blur) return;
    const double rho = along_z(p, 0.0), peak = 1.0 - std::exp(-0.5 * r * r / (blur * blur));
    const double noise = double(volume.values[v]) -
                         (image.background + (image.lumen - image.background) * 0.5 *
                                                 std::erfc((rho - r) / (std::sqrt(2.0) * blur)));
    volume.values[v] =
        float(image.background + noise +
              (image.lumen - image.background) * peak * std::exp(-0.5 * rho * rho / (blur * blur)));
  });
  const Segmentation result = segment_vessels(volume, {});
  EXPECT_EQ(piece_count(result.mask), 1);
  EXPECT_LT(interpolate(result.level_set, {0.07, -0.04, 15.0}), -1.0);
  EXPECT_LT(interpolate(result.level_set, {0.07, -0.04, -15.0}), -1.0);
}

}  // namespace
}  // namespace angio::segmentation

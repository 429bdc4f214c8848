#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "segmentation/segmentation.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation {
namespace {

using testing::HasSubstr;
constexpr double kPi = 3.14159265358979323846;
constexpr double kRadius = 1.5;
using Shape = std::function<double(const Vec3&)>;

/// A tube of 400 along z with another object of any intensity beside it.
Volume<float> tube_and(double intensity, double noise, const Shape& object) {
  TubeImage image;
  image.size = {70, 60, 70};
  image.blur_mm = 0.2;
  TubeImage alone = image;
  alone.lumen = intensity;
  image.noise_sd = noise;
  auto volume = image_of(image, [](const Vec3& p) { return along_z(p, kRadius); });
  const auto other = image_of(alone, object);
  // The brighter wins where both are: the object lies on top.
  for (std::size_t v = 0; v < volume.values.size(); ++v) {
    const double share = (other.values[v] - 40.0) / (intensity - 40.0);
    volume.values[v] = float(volume.values[v] * (1.0 - share) + intensity * share);
  }
  return volume;
}

Shape box(const Vec3& low, const Vec3& high) {
  return [low, high](const Vec3& p) {
    double d = -1e30;
    for (int a = 0; a < 3; ++a) d = std::max({d, low[a] - p[a], p[a] - high[a]});
    return d;
  };
}

/// The mean radius over the sides that look away from the object, which lies at positive x.
double mean_radius(const Volume<float>& level_set, double z_from, double z_to, int first,
                   int last) {
  double sum = 0.0;
  int count = 0;
  for (double z = z_from; z <= z_to; z += 0.5)
    for (int ray = first; ray < last; ++ray) {
      const Vec3 along{std::cos(ray * kPi / 18), std::sin(ray * kPi / 18), 0.0};
      double before = -1.0;
      for (double r = 0.05; r < 8.0; r += 0.05) {
        const double here = interpolate(level_set, Vec3{0.07, -0.04, z} + r * along);
        if (here >= 0.0) {
          sum += r - 0.05 * here / (here - before);
          ++count;
          break;
        }
        before = here;
      }
    }
  return count > 0 ? sum / count : 0.0;
}

TEST(ExcludeBone, KeepsABonePlateBesideAVesselOut) {
  for (double gap : {1.5, 0.6})
    for (double noise : {0.0, 36.0}) {
      const double x = 0.07 + kRadius + gap;
      const auto volume = tube_and(900.0, noise, box({x, -5, -6}, {x + 3.0, 5, 6}));
      const auto result = segment_vessels(volume, {});
      EXPECT_GT(interpolate(result.level_set, {x + 1.5, 0, 0}), 0.5) << gap << ' ' << noise;
      EXPECT_NEAR(mean_radius(result.level_set, -5, 5, 0, 36), kRadius, 0.05 * kRadius)
          << gap << ' ' << noise;
      ASSERT_THAT(result.warnings, testing::Contains(HasSubstr("segmentation.exclude_bone")));
    }
}

TEST(ExcludeBone, CutsABoneThatTouchesTheVesselOff) {
  for (double noise : {0.0, 36.0}) {
    const auto volume = tube_and(900.0, noise, [](const Vec3& p) {
      return norm(p - Vec3{0.07 + kRadius + 3.4, 0, 0}) - 3.5;
    });
    const auto result = segment_vessels(volume, {});
    EXPECT_GT(interpolate(result.level_set, {0.07 + kRadius + 3.4, 0, 0}), 1.0) << noise;
    EXPECT_NEAR(mean_radius(result.level_set, 4, 8, 0, 36), kRadius, 0.05 * kRadius) << noise;
    EXPECT_NEAR(mean_radius(result.level_set, -2, 2, 9, 27), kRadius, 0.05 * kRadius) << noise;
  }
}

TEST(ExcludeBone, KeepsAMetalSphereOut) {
  const auto volume = tube_and(3000.0, 36.0, [](const Vec3& p) {
    return norm(p - Vec3{6, 0, 0}) - 2.5;
  });
  const auto result = segment_vessels(volume, {});
  EXPECT_LT(interpolate(result.level_set, {0, 0, 0}), -1.0);
  EXPECT_GT(interpolate(result.level_set, {6, 0, 0}), 1.0);
  EXPECT_NEAR(mean_radius(result.level_set, -5, 5, 0, 36), kRadius, 0.05 * kRadius);
}

TEST(ExcludeBone, DoesNothingWhereItIsSwitchedOffOrASeedLiesInTheObject) {
  const auto volume = tube_and(900.0, 0.0, [](const Vec3& p) {
    return norm(p - Vec3{4.5, 0, 0}) - 3.2;
  });
  SegmentationOptions options;
  options.exclude_bone = false;
  EXPECT_LT(interpolate(segment_vessels(volume, options).level_set, {4.5, 0, 0}), -1.0);
  options.exclude_bone = true;
  options.seeds_lps_mm = {{4.5, 0, 0}};
  EXPECT_LT(interpolate(segment_vessels(volume, options).level_set, {4.5, 0, 0}), -1.0);
}

TEST(ExcludeBone, LeavesAnAneurysmWhole) {
  // As bright as its vessel, and a quarter of the contrast brighter.
  for (double intensity : {400.0, 490.0}) {
    const auto volume = tube_and(intensity, 36.0, [](const Vec3& p) {
      return norm(p - Vec3{4.5, 0, 0}) - 3.5;
    });
    const auto result = segment_vessels(volume, {});
    EXPECT_LT(interpolate(result.level_set, {4.5, 0, 0}), -3.0) << intensity;
    EXPECT_THAT(result.warnings, testing::IsEmpty()) << intensity;
  }
}

TEST(ExcludeBone, LeavesAWideAortaWholeBesideFainterBranches) {
  TubeImage image;
  image.size = {110, 90, 80};
  image.spacing = {0.6, 0.6, 0.6};
  image.blur_mm = 0.4;
  image.noise_sd = 36.0;
  TubeImage branch = image;
  branch.noise_sd = 0.0;
  branch.lumen = 240.0;
  auto volume = image_of(image, [](const Vec3& p) { return std::hypot(p.x + 8.0, p.y) - 12.5; });
  const auto faint = image_of(
      branch, [](const Vec3& p) { return p.x > -8.0 ? std::hypot(p.y, p.z) - 1.8 : 100.0; });
  for (std::size_t v = 0; v < volume.values.size(); ++v)
    volume.values[v] = std::max(volume.values[v], faint.values[v]);
  const auto result = segment_vessels(volume, {});
  EXPECT_LT(interpolate(result.level_set, {-8, 0, 5}), -12.0);
  EXPECT_NEAR(interpolate(result.level_set, {-8, 12.5, 5}), 0.0, 0.1);
}

}  // namespace
}  // namespace angio::segmentation

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "core/error.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/seeds.hpp"
#include "segmentation/segmentation.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation {
namespace {

using testing::HasSubstr;
constexpr double kPi = 3.14159265358979323846;

/// The mean radius of the zero of a level set around an axis along z, over the middle slices.
double mean_radius(const Volume<float>& level_set, double x, double y, double half_length) {
  double sum = 0.0;
  int count = 0;
  for (double z = -half_length; z <= half_length; z += 0.5)
    for (int ray = 0; ray < 36; ++ray) {
      const Vec3 along{std::cos(ray * kPi / 18), std::sin(ray * kPi / 18), 0.0};
      double before = interpolate(level_set, {x, y, z});
      for (double r = 0.05; r < 8.0; r += 0.05) {
        const double here = interpolate(level_set, Vec3{x, y, z} + r * along);
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

Volume<float> tube(const TubeImage& image, double radius) {
  return image_of(image, [&](const Vec3& p) { return along_z(p, radius); });
}

std::string refusal(const Volume<float>& volume, const SegmentationOptions& options = {}) {
  try {
    segment_vessels(volume, options);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(SegmentationOptions, DefaultsAreValid) { EXPECT_NO_THROW(SegmentationOptions{}.validate()); }

TEST(SegmentationOptions, NameTheFieldThatIsWrong) {
  SegmentationOptions options;
  options.scale_count = 0;
  try {
    options.validate();
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_THAT(error.what(), HasSubstr("segmentation.scale_count"));
  }
  options = {};
  options.smallest_radius_mm = 7.0;
  EXPECT_THROW(options.validate(), OptionError);
  options = {};
  options.intensity_min = 3.0;
  options.intensity_max = 3.0;
  EXPECT_THROW(options.validate(), OptionError);
}

TEST(SegmentVessels, FindsTheRadiusOfATubeToATwentiethOfAVoxel) {
  for (double radius : {1.0, 1.5, 2.5}) {
    TubeImage image;
    image.blur_mm = 0.1;
    const auto result = segment_vessels(tube(image, radius), {});
    EXPECT_NEAR(mean_radius(result.level_set, 0.07, -0.04, 5.0), radius, 0.015) << radius;
    EXPECT_NEAR(result.lumen_intensity, 400.0, 15.0);
    EXPECT_NEAR(result.background_intensity, 40.0, 4.0);
  }
}

TEST(SegmentVessels, KeepsTheRadiusUnderNoise) {
  for (double noise : {0.1, 0.2}) {
    TubeImage image;
    image.noise_sd = noise * 360.0;
    const auto result = segment_vessels(tube(image, 1.5), {});
    EXPECT_NEAR(mean_radius(result.level_set, 0.07, -0.04, 5.0), 1.5, 0.04) << noise;
  }
}

TEST(SegmentVessels, KeepsTheRadiusOnAnisotropicVoxels) {
  TubeImage image;
  image.spacing = {0.3, 0.3, 0.6};
  image.size = {48, 48, 40};
  EXPECT_NEAR(mean_radius(segment_vessels(tube(image, 1.5), {}).level_set, 0.07, -0.04, 5.0), 1.5,
              0.03);
}

TEST(SegmentVessels, DoesNotDependOnTheIntensityScale) {
  TubeImage image;
  image.noise_sd = 20.0;
  const auto volume = tube(image, 1.2);
  auto scaled = volume;
  for (float& v : scaled.values) v = 0.25f * v - 1000.0f;
  const auto a = segment_vessels(volume, {});
  const auto b = segment_vessels(scaled, {});
  ASSERT_EQ(a.level_set.geometry, b.level_set.geometry);
  for (std::size_t v = 0; v < a.level_set.values.size(); ++v)
    ASSERT_NEAR(a.level_set.values[v], b.level_set.values[v],
                std::abs(a.level_set.values[v]) < 1.2 ? 1e-3 : 0.15);  // exact to four voxels
}

TEST(SegmentVessels, WorksOnEightBits) {
  TubeImage image;
  image.lumen = 180;
  image.background = 12;
  image.noise_sd = 8;
  auto volume = tube(image, 1.5);
  for (float& v : volume.values) v = std::clamp(std::round(v), 0.0f, 255.0f);
  EXPECT_NEAR(mean_radius(segment_vessels(volume, {}).level_set, 0.07, -0.04, 5.0), 1.5, 0.03);
}

TEST(SegmentVessels, FollowsALumenThatFadesAlongItsWay) {
  TubeImage image;
  const auto share = tube({image.size, image.spacing, 1.0, 0.0, image.blur_mm}, 1.5);
  auto volume = share;
  const auto& g = volume.geometry;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i)
        volume.at(i, j, k) = 40.0f + share.at(i, j, k) * (400.0f - 3.0f * float(k));
  EXPECT_NEAR(mean_radius(segment_vessels(volume, {}).level_set, 0.07, -0.04, 7.0), 1.5, 0.03);
}

TEST(SegmentVessels, KeepsATightStenosisOpenAndItsDiameter) {
  // Radius 1.5 mm with a throat of 0.6 mm: 60 % by diameter.
  const auto radius_at = [](double z) {
    return 1.5 - (std::abs(z) < 4.0 ? 0.45 * (1.0 + std::cos(kPi * z / 4.0)) : 0.0);
  };
  for (double noise : {0.0, 0.1}) {
    TubeImage image;
    image.size = {40, 40, 80};
    image.noise_sd = 360.0 * noise;
    const auto volume = image_of(image, [&](const Vec3& p) { return along_z(p, radius_at(p.z)); });
    const auto result = segment_vessels(volume, {});
    const double throat = mean_radius(result.level_set, 0.07, -0.04, 0.1);
    EXPECT_NEAR(2.0 * throat, 1.2, 0.12) << noise;
    EXPECT_EQ(detail::label_components(result.mask, detail::Connectivity::faces).count(), 1);
  }
}

TEST(SegmentVessels, TakesTheTreeOfTheSeedAndTellsOfTheRest) {
  TubeImage image;
  image.size = {80, 40, 40};
  const auto volume = image_of(image, [](const Vec3& p) {
    return std::min(std::hypot(p.x + 6.0, p.y) - 2.0, std::hypot(p.x - 6.0, p.y) - 1.2);
  });
  SegmentationOptions options;
  options.seeds_lps_mm = {{6.1, 0.1, 0.5}};
  const auto small = segment_vessels(volume, options);
  EXPECT_LT(interpolate(small.level_set, {6, 0, 0}), 0.0);
  EXPECT_GT(interpolate(small.level_set, {-6, 0, 0}), 0.0);
  EXPECT_EQ(small.seeds_lps_mm.size(), 1u);
  ASSERT_EQ(small.warnings.size(), 1u);
  // It says where: a seed that finds what was left out.
  double x = 0.0, y = 0.0, z = 0.0;
  const std::string& rest = small.warnings[0];
  ASSERT_EQ(std::sscanf(rest.c_str() + rest.find('('), "(%lf, %lf, %lf)", &x, &y, &z), 3) << rest;
  options.seeds_lps_mm = {{x, y, z}};
  EXPECT_LT(interpolate(segment_vessels(volume, options).level_set, {-6, 0, 0}), 0.0);
  options.seeds_lps_mm = {{6.1, 0.1, 0.5}, {-6.1, 0.1, 0.5}};
  const auto both = segment_vessels(volume, options);
  EXPECT_LT(interpolate(both.level_set, {6, 0, 0}), 0.0);
  EXPECT_LT(interpolate(both.level_set, {-6, 0, 0}), 0.0);
  options.seeds_lps_mm = {{0.0, 0.0, 0.0}};
  EXPECT_THAT(refusal(volume, options), HasSubstr("lies in no vessel"));
  options.seeds_lps_mm = {{500.0, 0.0, 0.0}};
  EXPECT_THAT(refusal(volume, options), HasSubstr("outside the volume"));
}

TEST(SegmentVessels, ASeedTellsWhatIsTooBrightForItsVessel) {
  // Beside a rod three times as bright, wider and even, as little of a skeleton is.
  TubeImage image;
  image.size = {100, 60, 60};
  image.noise_sd = 20.0;
  auto volume = image_of(image, [](const Vec3& p) { return std::hypot(p.x - 7.0, p.y) - 2.0; });
  TubeImage rod = image;
  rod.lumen = 1160.0;
  rod.background = rod.noise_sd = 0.0;
  const auto bright = image_of(rod, [](const Vec3& p) { return std::hypot(p.x + 6.0, p.y) - 4.0; });
  for (std::size_t v = 0; v < volume.values.size(); ++v) volume.values[v] += bright.values[v];
  SegmentationOptions options;
  options.seeds_lps_mm = {{7.6, 0.3, 0.0}};
  const auto vessel = segment_vessels(volume, options);
  EXPECT_GT(interpolate(vessel.level_set, {-6, 0, 0}), 0.0);
  EXPECT_NEAR(mean_radius(vessel.level_set, 7.07, -0.04, 5.0), 2.0, 0.06);
  EXPECT_NEAR(vessel.lumen_intensity, 400.0, 30.0);
}

TEST(AxesOfSeeds, AreThoseOfUpToTwiceTheContrastOfTheTubesThatSeedsLieIn) {
  VolumeGeometry grid;
  grid.size = {100, 10, 10};
  const auto axis = [&](int x, float intensity, float contrast) {
    return detail::TubeAxis{2.0, {grid.offset(x, 5, 5)}, 1.0, {intensity}, {contrast}};
  };
  const std::vector<detail::TubeAxis> axes{axis(10, 300.0f, 250.0f), axis(30, 540.0f, 490.0f),
                                           axis(50, 560.0f, 510.0f), axis(70, 120.0f, 70.0f)};
  EXPECT_EQ(detail::axes_of_seeds(axes, grid, {}).size(), 4u);
  EXPECT_EQ(detail::axes_of_seeds(axes, grid, {{10, 5, 8}}).size(), 4u) << "beside its tube";
  const auto left = detail::axes_of_seeds(axes, grid, {{11, 5, 5}});
  ASSERT_EQ(left.size(), 3u);
  EXPECT_EQ(left[1].intensity[0], 540.0f);
  EXPECT_EQ(left[2].intensity[0], 120.0f);
  EXPECT_EQ(detail::axes_of_seeds(axes, grid, {{11, 5, 5}, {50, 5, 5}}).size(), 4u);
}

TEST(SegmentVessels, DoubtsATreeThatIsLessThanManyPiecesBesideIt) {
  TubeImage image;
  image.size = {120, 120, 100};
  const auto volume = image_of(image, [](const Vec3& p) {
    double nearest = std::hypot(p.x, p.y) - 1.5;
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j <= 2; ++j)
        if (i != 0 || j != 0)
          nearest =
              std::min(nearest, norm(p - Vec3{7.0 * i, 7.0 * j, std::clamp(p.z, -1.5, 1.5)}) - 1.0);
    return nearest;
  });
  SegmentationOptions options;
  const auto doubted = segment_vessels(volume, options).warnings;
  EXPECT_EQ(std::count_if(doubted.begin(), doubted.end(),
                          [](const auto& w) { return w.starts_with(kOutweighedLumen); }),
            1);
  options.seeds_lps_mm = {{0.1, 0.1, 0.5}};
  const auto asked = segment_vessels(volume, options).warnings;
  EXPECT_EQ(std::count_if(asked.begin(), asked.end(),
                          [](const auto& w) { return w.starts_with(kOutweighedLumen); }),
            0);
}

/// A tube and a second one of a share of its length, 6 mm apart.
Volume<float> two_tubes(double share) {
  TubeImage image;
  image.size = {60, 40, 100};
  image.noise_sd = 5.0;
  const double end = -0.5 * 99 * 0.3 + share * 30.0;
  return image_of(image, [&](const Vec3& p) {
    const double second = std::max(along_z(p - Vec3{3.0, 0.0, 0.0}, 1.2), p.z - end);
    return std::min(along_z(p - Vec3{-3.0, 0.0, 0.0}, 1.2), second);
  });
}

TEST(SegmentVessels, TakesEveryLargeTree) {
  for (const double share : {1.0, 0.5, 0.1}) {
    const Segmentation result = segment_vessels(two_tubes(share), {});
    const auto is_inside = [&](const Vec3& p) {
      const Vec3 at = result.mask.geometry.index_from_lps(p);
      const int i = int(std::lround(at.x)), j = int(std::lround(at.y)), k = int(std::lround(at.z));
      return result.mask.geometry.contains(i, j, k) && result.mask.at(i, j, k) != 0;
    };
    EXPECT_TRUE(is_inside({-2.93, -0.04, 0.0})) << share;
    EXPECT_EQ(is_inside({3.07, -0.04, -13.5}), share > 0.2) << share;
    EXPECT_EQ(result.seeds_lps_mm.size(), share > 0.2 ? 2U : 1U) << share;
  }
}

TEST(SegmentVessels, ClosesTheLevelSetAroundAVesselThatStaysInside) {
  TubeImage image;
  const auto volume = image_of(image, [](const Vec3& p) {
    return std::hypot(std::hypot(p.x, p.y) - 4.0, p.z) - 1.0;  // a ring
  });
  const auto result = segment_vessels(volume, {});
  const auto size = result.mask.geometry.size;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        const int margin = std::min({i, j, k, size[0] - 1 - i, size[1] - 1 - j, size[2] - 1 - k});
        if (margin < 3) {
          ASSERT_EQ(result.mask.at(i, j, k), 0);
        }
      }
  for (std::size_t v = 0; v < result.mask.values.size(); ++v)
    ASSERT_EQ(result.mask.values[v] != 0, result.level_set.values[v] < 0.0f);
}

TEST(SegmentVessels, RefusesAVolumeWithoutVessel) {
  TubeImage image;
  image.size = {40, 40, 40};
  EXPECT_THAT(refusal(image_of(image, [](const Vec3&) { return 100.0; })),
              HasSubstr("same intensity"));
  image.noise_sd = 30.0;
  EXPECT_THAT(refusal(image_of(image, [](const Vec3&) { return 100.0; })),
              HasSubstr("no vessel was found"));
  EXPECT_THAT(refusal(Volume<float>{}), HasSubstr("empty"));
}

TEST(SegmentVessels, FindsAWideAndAThinVesselInOneVolume) {
  TubeImage image;
  image.size = {110, 90, 60};
  image.spacing = {0.6, 0.6, 0.6};
  image.blur_mm = 0.4;
  image.noise_sd = 36.0;
  const auto volume = image_of(image, [](const Vec3& p) {
    const double wide = std::hypot(p.x + 8.0, p.y) - 12.5;
    const double thin = p.x > -8.0 ? std::hypot(p.y, p.z) - 0.9 : 100.0;
    return std::min(wide, thin);
  });
  const auto result = segment_vessels(volume, {});
  EXPECT_LT(interpolate(result.level_set, {-8, 0, 5}), -12.0);
  EXPECT_NEAR(interpolate(result.level_set, {-8, 12.5, 5}), 0.0, 0.1);
  EXPECT_LT(interpolate(result.level_set, {15, 0, 0}), -0.6);
  EXPECT_EQ(detail::label_components(result.mask, detail::Connectivity::faces).count(), 1);
}

TEST(SegmentVessels, DoesNotCareForTheBackgroundsLevelAndSign) {
  for (double background : {-1000.0, 0.0, 30000.0}) {
    TubeImage image;
    image.background = background;
    image.lumen = background + 300.0;
    image.noise_sd = 30.0;
    const auto result = segment_vessels(tube(image, 1.5), {});
    EXPECT_NEAR(mean_radius(result.level_set, 0.07, -0.04, 5.0), 1.5, 0.03) << background;
  }
}

TEST(SegmentVessels, KeepsAnAneurysmAndDropsNoiseIslands) {
  TubeImage image;
  image.size = {70, 70, 60};
  image.noise_sd = 36.0;
  const auto volume = image_of(image, [](const Vec3& p) {
    const double sac = norm(p - Vec3{4.5, 0.0, 0.0}) - 3.5;
    const double island = norm(p - Vec3{-7.0, 7.0, 3.0}) - 0.6;
    return std::min({along_z(p, 1.2), sac, island});
  });
  const auto result = segment_vessels(volume, {});
  EXPECT_LT(interpolate(result.level_set, {4.5, 0, 0}), -3.0);
  EXPECT_NEAR(interpolate(result.level_set, {8.0, 0, 0}), 0.0, 0.1);
  EXPECT_GT(interpolate(result.level_set, {-7, 7, 3}), 1.0);
}

TEST(SegmentVessels, KeepsVesselsThatNearlyTouchApart) {
  // Two tubes a voxel and a half apart, which the blur half fills.
  TubeImage image;
  image.size = {60, 40, 60};
  image.noise_sd = 18.0;
  const auto share = [&](double x) {
    TubeImage alone = image;
    alone.noise_sd = 0.0;
    return image_of(alone, [&](const Vec3& p) { return std::hypot(p.x - x, p.y) - 1.5; });
  };
  auto volume = image_of(image, [](const Vec3&) { return 100.0; });
  const auto a = share(-1.725), b = share(1.725);
  for (std::size_t v = 0; v < volume.values.size(); ++v)
    volume.values[v] += a.values[v] + b.values[v] - 80.0f;
  const auto result = segment_vessels(volume, {});
  EXPECT_GT(interpolate(result.level_set, {0, 0, 0}), 0.0);
}

TEST(SegmentVessels, TakesTheVesselOfTheRegionOfInterest) {
  TubeImage image;
  image.size = {80, 40, 40};
  const auto volume = image_of(image, [](const Vec3& p) {
    return std::min(std::hypot(p.x + 6.0, p.y) - 2.0, std::hypot(p.x - 6.0, p.y) - 1.2);
  });
  SegmentationOptions options;
  options.region_lps_mm = LpsBox{{1, -100, -100}, {100, 100, 100}};
  const auto result = segment_vessels(volume, options);
  EXPECT_LT(interpolate(result.level_set, {6, 0, 0}), -1.0);
  EXPECT_TRUE(result.warnings.empty());
  options.region_lps_mm = LpsBox{{100, 100, 100}, {200, 200, 200}};
  EXPECT_THAT(refusal(volume, options), HasSubstr("region_lps_mm"));
  options.region_lps_mm = LpsBox{{1, 0, 0}, {0, 1, 1}};
  EXPECT_THROW(options.validate(), OptionError);
}

TEST(SegmentVessels, TellsTheScannersBlur) {
  TubeImage image;
  for (double blur_voxels : {0.6, 1.0}) {
    // The test image has no voxel's own blur, h^2 / 12, which the model adds.
    image.blur_mm = 0.3 * std::sqrt(blur_voxels * blur_voxels + 1.0 / 12.0);
    const auto result = segment_vessels(tube(image, 3.0), {});
    EXPECT_NEAR(result.blur_sd_mm, 0.3 * blur_voxels, 0.02) << blur_voxels;
  }
}

TEST(SegmentVessels, RefusesVoxelsThatAreNotNumbers) {
  TubeImage image;
  auto volume = tube(image, 1.5);
  volume.values[17] = std::nanf("");
  EXPECT_THAT(refusal(volume), HasSubstr("not a number"));
}

TEST(SegmentVessels, GivesTheSameBytesForAnyNumberOfThreads) {
  TubeImage image;
  image.noise_sd = 30.0;
  const auto volume = tube(image, 1.5);
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const auto a = segment_vessels(volume, {});
  omp_set_num_threads(3);
  const auto b = segment_vessels(volume, {});
  omp_set_num_threads(threads);
  EXPECT_EQ(a.level_set.values, b.level_set.values);
  EXPECT_EQ(a.mask.values, b.mask.values);
}

TEST(SegmentVessels, CanBeInterrupted) {
  TubeImage image;
  EXPECT_THROW(
      segment_vessels(tube(image, 1.5), {}, Progress([](double fraction, std::string_view) {
                        if (fraction > 0.4) throw Interrupted();
                      })),
      Interrupted);
}

}  // namespace
}  // namespace angio::segmentation

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/error.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/boundary.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/plausibility.hpp"
#include "segmentation/detail/tunnels.hpp"
#include "segmentation/detail/vessel_tree.hpp"
#include "segmentation/segmentation.hpp"
#include "tests/segmentation/grids.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kLung = -850.0, kMuscle = 50.0, kBlood = 450.0;

/// Blood of a chest: a chamber with an aorta in muscle, and thin branches that leave it into lung.
double chest_blood(const Vec3& p) {
  const double chamber = norm(p - Vec3{-22, 0, 0}) - 13.0;
  const double aorta = std::hypot(p.x + 22.0, p.y) - 7.0;
  double vessels = std::min(chamber, aorta);
  for (const double z : {-16.0, 0.0, 16.0})
    if (p.x > -22.0) vessels = std::min(vessels, std::hypot(p.y, p.z - z) - 2.4);
  return vessels;
}

/// Muscle up to x = 0, lung beyond; every boundary blurred, with noise.
/// @param radius  of another aorta, at the border of both; 0: none
/// @param wall    of muscle round it
Volume<float> chest(double noise, double radius = 0.0, double wall = 0.0) {
  TubeImage muscle{{66, 48, 48}, {1.3, 1.3, 1.3}, kMuscle, kLung, 0.8, noise, 5};
  TubeImage blood = muscle;
  blood.lumen = 1.0;
  blood.background = blood.noise_sd = 0.0;
  const auto second = [](const Vec3& p, double r) { return std::hypot(p.x, p.y) - r; };
  auto volume = image_of(muscle, [&](const Vec3& p) {
    return radius > 0.0 ? std::min(p.x, second(p, radius + wall)) : p.x;
  });
  const auto share = image_of(blood, [&](const Vec3& p) {
    return radius > 0.0 ? std::min(chest_blood(p), second(p, radius)) : chest_blood(p);
  });
  for (std::size_t v = 0; v < volume.values.size(); ++v)
    volume.values[v] += float(share.values[v] * (kBlood - double(volume.values[v])));
  return volume;
}

TEST(BloodLevel, IsThatOfTheLumenAboveMuscleAndNotAboveLung) {
  for (const double noise : {0.0, 25.0}) {
    const auto volume = chest(noise);
    const auto level = detail::find_blood_level(detail::find_tube_axes(volume), volume,
                                                detail::noise_deviation(volume));
    ASSERT_TRUE(level.is_told);
    EXPECT_NEAR(level.lumen, kBlood, 25.0) << noise;
    EXPECT_NEAR(level.tissue, kMuscle, 15.0) << noise;
  }
}

// Lung and muscle fill the scan, blood is too uneven for a mode of its own, and half of the tubes
// are thin vessels in lung, whose voxels are part of it.
TEST(BloodLevel, IsNotThatOfMuscleAmongLungs) {
  std::mt19937 random(3);
  std::normal_distribution<float> lung(-900.0f, 40.0f), muscle(float(kMuscle), 25.0f);
  std::normal_distribution<float> above(0.0f, 100.0f);
  std::uniform_real_distribution<float> blood(180.0f, 300.0f), thin(-450.0f, 40.0f);
  VolumeGeometry grid;
  grid.size = {60, 60, 60};
  Volume<float> volume(grid);
  for (std::size_t v = 0; v < volume.values.size(); ++v) {
    const std::size_t part = v % 100;
    volume.values[v] = part < 52   ? lung(random)
                       : part < 95 ? muscle(random)
                                   : float(kMuscle) + std::abs(above(random));
  }
  detail::TubeAxis axis{3.0, {}, 1.0, {}, {}};
  for (std::size_t n = 0; n < 1000; ++n) {
    axis.voxels.push_back(n);
    axis.intensity.push_back(n % 2 == 0 ? thin(random) : blood(random));
    axis.contrast.push_back(300.0f);
  }
  const auto level = detail::find_blood_level({axis}, volume, 5.0);
  EXPECT_NEAR(level.tissue, kMuscle, 15.0);
  EXPECT_NEAR(level.lumen, 240.0, 20.0);
}

TEST(BloodLevel, IsNotToldWithoutTubes) {
  TubeImage image{{30, 30, 30}, {1, 1, 1}, 400, 40, 0.5};
  const auto ball = image_of(image, [](const Vec3& p) { return norm(p) - 6.0; });
  EXPECT_FALSE(detail::find_blood_level({}, ball, 0.0).is_told);
}

TEST(SegmentVessels, TakesBloodAndNoMuscleWhereBranchesLieInLung) {
  const auto volume = chest(25.0);
  const auto result = segment_vessels(volume, {});
  const auto& grid = result.level_set.geometry;
  double wrong = 0.0, all = 0.0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const double truth = chest_blood(grid.lps_from_index({double(i), double(j), double(k)}));
        const bool is_lumen = result.mask.at(i, j, k) != 0;
        all += truth < 0.0;
        wrong += is_lumen ? truth > 1.3 : truth < -1.3;
      }
  // Farther than a voxel from the truth: where a branch leaves muscle for lung, by half a voxel.
  EXPECT_LT(wrong, 0.015 * all);
  for (const Vec3& inside : {Vec3{-22, 0, 0}, Vec3{-22, 0, 20}, Vec3{25, 0, 16}, Vec3{25, 0, -16}})
    EXPECT_LT(interpolate(result.level_set, inside), -1.0) << inside.x << ' ' << inside.z;
}

// An aorta whose wall of 2.5 mm has lung on one side and muscle on the other: blood ends at the
// wall, not half-way to lung.
TEST(FindBoundary, EndsAtTheWallOfAnAortaBesideLung) {
  constexpr double kRadius = 10.0, kWall = 2.5;
  const auto volume = chest(20.0, kRadius, kWall);
  Volume<std::uint8_t> tree(volume.geometry);  // with the wall, which is brighter than half-way
  for (std::size_t v = 0; v < tree.values.size(); ++v) {
    const Vec3 p = detail::place_of_voxel(volume.geometry, v);
    const bool is_blood = std::min(chest_blood(p), std::hypot(p.x, p.y) - kRadius) < 0.0;
    tree.values[v] = is_blood || (p.x > 0.0 && std::hypot(p.x, p.y) < kRadius + kWall);
  }
  detail::BloodLevel level;
  level.lumen = float(kBlood);
  level.tissue = float(kMuscle);
  level.is_told = level.is_even = true;
  const auto result =
      detail::find_boundary({volume, volume, tree, 0.0, 0.05, false, level}, {}, {});
  double beside_lung = 0.0, beside_muscle = 0.0;
  for (const double angle : {-0.9, -0.6, -0.3, 0.3, 0.6, 0.9})
    for (const double z : {-8.0, 8.0})
      for (const double side : {1.0, -1.0}) {
        const Vec3 out{side * std::cos(angle), std::sin(angle), 0.0};
        double r = 0.5 * kRadius;
        while (r < 2.0 * kRadius && interpolate(result.level_set, Vec3{0, 0, z} + r * out) < 0.0)
          r += 0.02;
        (side > 0.0 ? beside_lung : beside_muscle) += (r - kRadius) / 12.0;
      }
  EXPECT_NEAR(beside_muscle, 0.0, 0.2);
  EXPECT_NEAR(beside_lung, 0.0, 0.65);  // half a voxel
}

/// Noise whose neighbours are alike, as interpolated images and tissue have it.
Volume<float> texture(const VolumeGeometry& geometry, double smoothing_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(100.0f, 30.0f);
  Volume<float> volume(geometry);
  for (float& value : volume.values) value = noise(random);
  return detail::smooth(volume, smoothing_mm);
}

TEST(SegmentVessels, RefusesNoiseOfAnyTexture) {
  VolumeGeometry geometry;
  geometry.size = {48, 48, 48};
  geometry.spacing = {0.5, 0.5, 0.5};
  for (const double smoothing_mm : {0.0, 0.4, 0.8})
    for (const unsigned seed : {1u, 2u})
      EXPECT_THROW(segment_vessels(texture(geometry, smoothing_mm, seed), {}), InputError)
          << smoothing_mm << ' ' << seed;
}

TEST(SegmentVessels, TakesNoMuscleBesideAFaintBranch) {
  // A bright vessel, a thin branch with a quarter of its contrast, and textured tissue at its end.
  TubeImage image{{70, 60, 60}, {0.5, 0.5, 0.5}, 400, 40, 0.35, 10.0, 3};
  TubeImage branch = image;
  branch.noise_sd = 0.0;
  branch.lumen = 130.0;
  auto volume = image_of(image, [](const Vec3& p) { return std::hypot(p.x + 8.0, p.y) - 2.0; });
  const auto faint = image_of(branch, [](const Vec3& p) {
    return p.x > -8.0 && p.x < 6.0 ? std::hypot(p.y, p.z) - 0.9 : 100.0;
  });
  const auto tissue = texture(volume.geometry, 0.5, 7);
  const auto in_tissue = [](const Vec3& p) { return p.x > 5.0 && std::abs(p.z) < 10.0; };
  const auto& grid = volume.geometry;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        float& value = volume.at(i, j, k);
        value = std::max(value, faint.at(i, j, k));
        if (in_tissue(grid.lps_from_index({double(i), double(j), double(k)})))
          value = std::max(value, 80.0f + 2.0f * (tissue.at(i, j, k) - 100.0f));
      }
  const auto result = segment_vessels(volume, {});
  const auto& fine = result.mask.geometry;
  double taken = 0.0;
  for (int k = 0; k < fine.size[2]; ++k)
    for (int j = 0; j < fine.size[1]; ++j)
      for (int i = 0; i < fine.size[0]; ++i) {
        const Vec3 p = fine.lps_from_index({double(i), double(j), double(k)});
        taken += result.mask.at(i, j, k) && p.x > 7.0;
      }
  EXPECT_LT(taken * fine.spacing.x * fine.spacing.y * fine.spacing.z, 2.0);  // of 5000 mm3
}

TEST(SegmentVessels, TellsOfThinVesselsThatItLeavesOut) {
  // A wide vessel, and a thin one that does not touch it.
  TubeImage image{{60, 40, 60}, {0.4, 0.4, 0.4}, 400, 40, 0.24, 4.0, 2};
  const auto with_thin = image_of(image, [](const Vec3& p) {
    return std::min(std::hypot(p.x + 5.0, p.y) - 1.5,
                    std::abs(p.z) < 7.0 ? std::hypot(p.x - 5.0, p.y) - 0.2 : 100.0);
  });
  const auto alone =
      image_of(image, [](const Vec3& p) { return std::hypot(p.x + 5.0, p.y) - 1.5; });
  EXPECT_THAT(segment_vessels(with_thin, {}).warnings, Contains(HasSubstr("thin vessel")));
  EXPECT_THAT(segment_vessels(alone, {}).warnings, testing::IsEmpty());
}

/// The level set of a ball in a box.
Volume<float> ball(double radius, double box) {
  VolumeGeometry geometry;
  geometry.size = {40, 40, 40};
  geometry.spacing = {box / 40, box / 40, box / 40};
  for (int a = 0; a < 3; ++a) geometry.origin[a] = -0.5 * box + 0.5 * box / 40;
  Volume<float> level(geometry);
  for (int k = 0; k < 40; ++k)
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i)
        level.at(i, j, k) =
            float(norm(geometry.lps_from_index({double(i), double(j), double(k)})) - radius);
  return level;
}

TEST(Plausibility, RefusesWhatFillsTheVolumeAndTellsOfWideBodies) {
  const auto check = [](double radius, double box) {
    const auto level = ball(radius, box);
    Volume<std::uint8_t> mask(level.geometry);
    for (std::size_t v = 0; v < mask.values.size(); ++v) mask.values[v] = level.values[v] < 0.0f;
    detail::refuse_flood(mask, level.geometry);
    return detail::check_plausibility(level, level.geometry);
  };
  EXPECT_THROW(check(0.0, 16.0), InputError);                                    // nothing
  EXPECT_TRUE(check(4.0, 16.0).empty());                                         // 7 %
  EXPECT_THAT(check(7.0, 16.0), Contains(HasSubstr("of the volume is lumen")));  // 35 %
  EXPECT_THROW(check(8.3, 16.0), InputError);                                    // 57 %
  EXPECT_THAT(check(25.0, 100.0), Contains(HasSubstr("mm wide")));
  EXPECT_TRUE(check(4.5, 40.0).empty());
  // A wide body within the scan is no vessel; one that the border cuts may be.
  EXPECT_THAT(check(15.0, 100.0), ElementsAre(HasSubstr("border nowhere")));
  VolumeGeometry cut = ball(15.0, 100.0).geometry;
  cut.origin.x = -14.0;
  EXPECT_TRUE(detail::check_plausibility(ball(15.0, 100.0), cut).empty());
  EXPECT_FALSE(check(74.0, 220.0).empty());      // 1.70 l, 16 %
  EXPECT_THROW(check(76.0, 220.0), InputError);  // 1.84 l
}

/// Voxels of a box where a function of the place (in voxels) is true.
template <class Function>
Volume<std::uint8_t> mask_where(int size, Function&& is_inside) {
  VolumeGeometry grid;
  grid.size = {size, size, size};
  Volume<std::uint8_t> mask(grid, 0);
  for (int k = 0; k < size; ++k)
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) mask.at(i, j, k) = is_inside(i, j, k);
  return mask;
}

/// A lattice of rods along the three axes, `cells` to a side.
Volume<std::uint8_t> lattice(int cells) {
  constexpr int kCell = 4, kRod = 2;
  return mask_where(kCell * cells + kRod, [&](int i, int j, int k) {
    return (i % kCell < kRod) + (j % kCell < kRod) + (k % kCell < kRod) >= 2;
  });
}

TEST(Tunnels, AreThoseOfBodiesWhoseNumberIsKnown) {
  const auto ball = [](int i, int j, int k) {
    return (i - 10) * (i - 10) + (j - 10) * (j - 10) + (k - 10) * (k - 10) < 64;
  };
  const auto ring = [](int i, int j, int k) {
    const double r = std::hypot(i - 10.0, j - 10.0) - 6.0;
    return r * r + (k - 10.0) * (k - 10.0) < 6.0;
  };
  EXPECT_EQ(detail::least_tunnels(mask_where(21, ball)), 0);
  EXPECT_EQ(detail::least_tunnels(mask_where(21, ring)), 1);
  EXPECT_EQ(detail::least_tunnels(mask_where(5, [](int, int, int) { return true; })), 0);
  for (const int n : {1, 2, 5}) {
    // A network has edges - nodes + 1 independent rings.
    const int nodes = (n + 1) * (n + 1) * (n + 1), edges = 3 * n * (n + 1) * (n + 1);
    EXPECT_EQ(detail::least_tunnels(lattice(n)), edges - nodes + 1) << n;
  }
}

TEST(Plausibility, RefusesASpongeAndNoTreeWithLoops) {
  const auto sponge = lattice(9);  // 1701 tunnels in 53 % of the box
  EXPECT_THAT([&] { detail::refuse_sponge(sponge, sponge.geometry, false); },
              ThrowsMessage<InputError>(HasSubstr("1701 holes through it")));
  const auto fewer = lattice(7);  // 833
  EXPECT_NO_THROW(detail::refuse_sponge(fewer, fewer.geometry, false));
  VolumeGeometry wide = sponge.geometry;  // a nidus in the scan of a head
  for (int& n : wide.size) n *= 2;
  EXPECT_NO_THROW(detail::refuse_sponge(sponge, wide, false));
  const auto bone = lattice(12);  // 3888, too many at any size
  wide = bone.geometry;
  for (int& n : wide.size) n *= 4;
  EXPECT_THROW(detail::refuse_sponge(bone, wide, false), InputError);
  EXPECT_NO_THROW(detail::refuse_sponge(bone, wide, true));
}

TEST(Plausibility, RefusesASkullAndNoHeart) {
  const auto shell = [](double radius, double box) {
    Volume<float> level = ball(radius, box);
    Volume<std::uint8_t> mask(level.geometry);
    for (std::size_t v = 0; v < mask.values.size(); ++v)
      mask.values[v] = std::abs(level.values[v]) < 4.0f;
    return mask;
  };
  EXPECT_THAT([&] { detail::refuse_shell(shell(65.0, 160.0)); },  // 0.8 l inside
              ThrowsMessage<InputError>(HasSubstr("closes around 0.8 l")));
  EXPECT_NO_THROW(detail::refuse_shell(shell(35.0, 90.0)));  // 25 cm^2 in its widest section
}

TEST(Plausibility, RefusesACrumbInABodyAndNoVesselInACube) {
  Volume<std::uint8_t> mask(test::grid_of({40, 40, 60}, {0.5, 0.5, 0.5}));
  for (int k = 4; k < 24; ++k) mask.at(20, 20, k) = 1;  // 10 mm
  VolumeGeometry body = mask.geometry;
  body.size = {512, 512, 40};
  EXPECT_THAT([&] { detail::refuse_crumb(mask, body); },
              ThrowsMessage<InputError>(HasSubstr("in a scan of a body")));
  EXPECT_NO_THROW(detail::refuse_crumb(mask, mask.geometry));
  for (int k = 0; k < 60; ++k) mask.at(20, 20, k) = 1;  // 30 mm
  EXPECT_NO_THROW(detail::refuse_crumb(mask, body));
}

TEST(Plausibility, OfALumenWithoutContrastIsTold) {
  Volume<float> ct(test::grid_of({4, 4, 4}, {1.0, 1.0, 1.0}), 40.0f);
  ct.values[7] = -1000.0f;
  EXPECT_THAT(detail::check_contrast(45.0, ct), HasSubstr("contrast"));
  EXPECT_EQ(detail::check_contrast(180.0, ct), "");
  EXPECT_EQ(detail::check_contrast(-700.0, ct), "");  // another scale
  ct.values[7] = 0.0f;                                // MR
  EXPECT_EQ(detail::check_contrast(45.0, ct), "");
}

TEST(Plausibility, RefusesBoneAndNoBlood) {
  // A fifth of a ball is as dark, a fifth as bright as is said, the rest 200.
  const Volume<float> level = ball(10.0, 30.0);
  const auto image = [&](float dark, float bright) {
    Volume<float> values(level.geometry, 200.0f);
    for (std::size_t v = 0; v < values.values.size(); ++v)
      if (v % 5 < 2) values.values[v] = v % 5 == 0 ? dark : bright;
    return values;
  };
  EXPECT_EQ(detail::check_evenness(level, image(150.0f, 350.0f)), "");
  EXPECT_THAT(detail::check_evenness(level, image(100.0f, 400.0f)), HasSubstr("brighter than 400"));
  EXPECT_THAT([&] { detail::check_evenness(level, image(20.0f, 500.0f)); },
              ThrowsMessage<InputError>(HasSubstr("apart from bone")));
  EXPECT_EQ(detail::check_evenness(ball(1.0, 30.0), image(20.0f, 500.0f)), "")
      << "too thin to tell";
}

}  // namespace
}  // namespace angio::segmentation

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include "centerline/centerline.hpp"
#include "centerline/resolution.hpp"
#include "core/error.hpp"
#include "testing/centerline/shapes.hpp"
#include "tests/centerline/random_trees.hpp"

namespace angio::centerline {
namespace {

using test::grid_around;
using test::level_set_of;
using test::make_tube;
using test::straight_tube;
using test::Tube;

/// A vessel of radius R (1 - taper t), narrowed by `severity` at t = at over +-half of its length:
/// r = r0 (1 - severity (1 + cos(pi (t - at) / half)) / 2).
std::function<double(double)> vessel(double radius, double taper, double at, double half,
                                     double severity) {
  return [=](double t) {
    const double healthy = radius * (1.0 - taper * t);
    const double x = (t - at) / half;
    if (std::abs(x) >= 1.0) return healthy;
    return healthy * (1.0 - 0.5 * severity * (1.0 + std::cos(units::kPi * x)));
  };
}

CenterlineTree extract(const std::vector<Tube>& tubes, double noise = 0.0) {
  Volume<float> level_set = level_set_of(tubes, grid_around(tubes, 0.3, 1.5));
  if (noise > 0.0) test::add_noise(level_set, noise, 5);
  return extract_centerline(level_set, {}).tree;
}

TEST(LesionOptions, DefaultsAreValid) { EXPECT_NO_THROW(LesionOptions{}.validate()); }

TEST(LesionOptions, NamesTheBadField) {
  const auto words_of = [](double LesionOptions::*field, double value) -> std::string {
    LesionOptions options;
    options.*field = value;
    try {
      options.validate();
    } catch (const OptionError& error) {
      return error.what();
    }
    return "nothing is wrong";
  };
  using testing::StartsWith;
  EXPECT_THAT(words_of(&LesionOptions::min_stenosis_percent, 5.0),
              StartsWith("lesion.min_stenosis_percent is 5 "));
  EXPECT_THAT(words_of(&LesionOptions::min_reference_mm, 31.0),
              StartsWith("lesion.min_reference_mm is 31 "));
  EXPECT_THAT(words_of(&LesionOptions::voxel_mm, -1.0), StartsWith("lesion.voxel_mm is -1"));
  EXPECT_THAT(words_of(&LesionOptions::abscissa_mm, std::numeric_limits<double>::infinity()),
              StartsWith("lesion.abscissa_mm is not a number"));
}

TEST(FindLesions, ReadsA60PercentStenosis) {
  const auto tree = extract({straight_tube({0, 0, 0}, {3, 2, 30}, vessel(1.5, 0, 0.5, 0.2, 0.6))});
  const auto lesions = find_lesions(tree, {});
  ASSERT_EQ(lesions.size(), 1U);
  const Lesion& lesion = lesions[0];
  EXPECT_TRUE(lesion.is_stenosis);
  EXPECT_EQ(lesion.reference_rule, "tree");
  EXPECT_NEAR(lesion.mld_mm, 1.2, 0.03);
  EXPECT_NEAR(lesion.mla_mm2, units::kPi * 0.36, 0.03);
  EXPECT_NEAR(lesion.reference_diameter_mm, 3.0, 0.05);
  EXPECT_NEAR(lesion.diameter_stenosis_percent, 60.0, 1.0);
  const Vec3 middle = sample(tree.paths[0], lesion.abscissa_mm).point;
  EXPECT_LT(distance(middle, {1.5, 1.0, 15.0}), 0.3);
  // 0.6 (1 + cos(pi x)) / 2 = 0.2 at x = acos(-1/3) / pi = 0.608 of the half length.
  EXPECT_NEAR(lesion.length_mm, 2.0 * 0.608 * 0.2 * norm(Vec3{3, 2, 30}), 0.4);
}

TEST(FindLesions, MeasuresNoStenosisInAVesselUnderThreeVoxelsWide) {
  const auto tree = extract({straight_tube({0, 0, 0}, {3, 2, 30}, vessel(1.5, 0, 0.5, 0.2, 0.6))});
  EXPECT_TRUE(find_lesions(tree, {.voxel_mm = 0.9}).front().is_stenosis);
  const auto lesions = find_lesions(tree, {.voxel_mm = 1.1});
  ASSERT_EQ(lesions.size(), 2U);
  EXPECT_FALSE(lesions[0].is_stenosis);
  EXPECT_FALSE(lesions[0].is_too_thin);
  EXPECT_TRUE(lesions[1].is_too_thin);
  EXPECT_FALSE(lesions[1].is_stenosis);
  EXPECT_THROW((void)find_lesions(tree, {.voxel_mm = -1.0}), OptionError);
}

TEST(FindLesions, TakesTheReferenceOfATaperedVesselWhereTheLesionIs) {
  const auto tree =
      extract({straight_tube({0, 0, 0}, {3, 2, 40}, vessel(1.5, 0.4, 0.6, 0.15, 0.5))});
  const auto lesions = find_lesions(tree, {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_NEAR(lesions[0].reference_diameter_mm, 3.0 * (1.0 - 0.4 * 0.6), 0.06);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 50.0, 1.5);
}

TEST(FindLesions, ReadsAnEccentricStenosisThroughNoise) {
  const auto radius = vessel(1.5, 0, 0.5, 0.2, 0.6);
  const Tube tube = make_tube([&](double t) { return Vec3{1.5 - radius(t), 0, 30 * t}; }, radius);
  for (const double noise : {0.0, 0.05, 0.1}) {
    const auto lesions = find_lesions(extract({tube}, noise), {});
    ASSERT_EQ(lesions.size(), 1U);
    EXPECT_TRUE(lesions[0].is_stenosis);
    EXPECT_NEAR(lesions[0].mld_mm, 1.2, 0.02 + noise);
    EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 60.0, 1.0 + 30.0 * noise);
  }
}

/// Noise that goes together over the scanner's blur: white noise through a Gaussian.
void add_blurred_noise(Volume<float>& level_set, double sd_mm, double blur_mm, unsigned seed) {
  const auto [ni, nj, nk] = level_set.geometry.size;
  std::vector<double> field(level_set.values.size());
  std::mt19937 random(seed);
  std::normal_distribution<double> gauss;
  for (double& value : field) value = gauss(random);
  const double sigma = blur_mm / level_set.geometry.spacing.x;
  const int reach = int(std::ceil(3.0 * sigma));
  const std::ptrdiff_t strides[] = {1, ni, std::ptrdiff_t(ni) * nj};
  const std::ptrdiff_t sizes[] = {ni, nj, nk};
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double> before = field;
    for (std::ptrdiff_t n = 0; n < std::ptrdiff_t(field.size()); ++n) {
      const std::ptrdiff_t at = n / strides[axis] % sizes[axis];
      double sum = 0.0;
      for (std::ptrdiff_t step = -reach; step <= reach; ++step) {
        const std::ptrdiff_t to = std::clamp<std::ptrdiff_t>(at + step, 0, sizes[axis] - 1);
        sum += std::exp(-0.5 * double(step * step) / (sigma * sigma)) *
               before[std::size_t(n + (to - at) * strides[axis])];
      }
      field[std::size_t(n)] = sum;
    }
  }
  double squares = 0.0;
  for (const double value : field) squares += value * value;
  const double scale = sd_mm / std::sqrt(squares / double(field.size()));
  for (std::size_t n = 0; n < field.size(); ++n) level_set.values[n] += float(scale * field[n]);
}

TEST(FindLesions, ReadsARoundThroatRoundInNoiseThatGoesTogether) {
  // A few lumps round a throat look like a flat lumen, whose largest ball is smaller than its area.
  const std::vector<Tube> tube = {
      straight_tube({0, 0, 0}, {4, 2, 50}, vessel(2.0, 0.0, 0.5, 0.1, 0.7))};
  constexpr double kBlur = 0.4;
  CenterlineOptions options;
  options.voxel_mm = 0.5;  // the level set's own are half as wide
  double roundness = 0.0, worst = 1.0;
  constexpr int kSeeds = 12;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Volume<float> level_set = level_set_of(tube, grid_around(tube, 0.25, 1.5));
    for (float& value : level_set.values)
      value = float(0.5 * std::erf(double(value) / (kBlur * std::sqrt(2.0))));
    add_blurred_noise(level_set, 0.12, kBlur, seed);
    const auto lesions = find_lesions(extract_centerline(level_set, options).tree, {});
    ASSERT_EQ(lesions.size(), 1U) << seed;
    const double round = lesions[0].mld_mm / (2.0 * std::sqrt(lesions[0].mla_mm2 / units::kPi));
    roundness += round / kSeeds;
    worst = std::min(worst, round);
  }
  EXPECT_GT(roundness, 0.995);
  EXPECT_GT(worst, 0.98);
}

TEST(FindLesions, ReadsAFlatThroatFlatInNoise) {
  // Pressed in from two sides: a circle between two planes, which few harmonics describe badly.
  const std::vector<Tube> tube = {
      straight_tube({0, 0, 0}, {0, 0, 40}, vessel(1.5, 0.0, 0.5, 0.1, 0.0))};
  CenterlineOptions options;
  options.voxel_mm = 0.3;
  Volume<float> level_set = level_set_of(tube, grid_around(tube, 0.15, 1.0));
  const auto half_width = vessel(1.5, 0.0, 0.5, 0.11, 0.5);
  const VolumeGeometry& grid = level_set.geometry;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = grid.lps_from_index({double(i), double(j), double(k)});
        level_set.at(i, j, k) =
            std::max(level_set.at(i, j, k), float(std::abs(p.x) - half_width(p.z / 40.0)));
      }
  add_blurred_noise(level_set, 0.02, 0.2, 1);
  const auto lesions = find_lesions(extract_centerline(level_set, options).tree, {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_NEAR(lesions[0].mld_mm, 1.5, 0.06);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 50.0, 2.5);
}

TEST(FindLesions, InventsNoneInAHealthyTaperedVessel) {
  for (const double noise : {0.0, 0.08}) {
    const auto tree =
        extract({straight_tube({0, 0, 0}, {3, 2, 40}, vessel(1.6, 0.6, 0.5, 0.1, 0.0))}, noise);
    const auto lesions = find_lesions(tree, {});
    ASSERT_EQ(lesions.size(), 1U);
    EXPECT_FALSE(lesions[0].is_stenosis);
    EXPECT_GT(lesions[0].abscissa_mm, 5.0);
    EXPECT_LT(lesions[0].abscissa_mm, tree.paths[0].abscissa.back() - 5.0);
  }
}

std::vector<Tube> y_shape(double trunk, double branch) {
  return {straight_tube({0, 0, 0}, {0, 0, 30}, vessel(2.0, 0, 0.5, 0.2, trunk)),
          straight_tube({0, 0, 30}, {8, 0, 52}, vessel(1.5, 0.1, 0.5, 0.2, 0.0)),
          straight_tube({0, 0, 30}, {-10, 1, 56}, vessel(1.3, 0.1, 0.55, 0.2, branch))};
}

TEST(FindLesions, InventsNoneAtAHealthyBifurcation) {
  const auto lesions = find_lesions(extract(y_shape(0.0, 0.0)), {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_FALSE(lesions[0].is_stenosis);
  EXPECT_LT(lesions[0].diameter_stenosis_percent, 20.0);
}

TEST(FindLesions, ReportsALesionOfASharedTrunkOnce) {
  const auto lesions = find_lesions(extract(y_shape(0.5, 0.0)), {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_TRUE(lesions[0].is_stenosis);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 50.0, 2.0);
  EXPECT_EQ(lesions[0].path_id, 0);
}

TEST(FindLesions, PutsTheMostSevereFirst) {
  const auto lesions = find_lesions(extract(y_shape(0.4, 0.6)), {});
  ASSERT_EQ(lesions.size(), 2U);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 60.0, 2.5);
  EXPECT_NEAR(lesions[1].diameter_stenosis_percent, 40.0, 2.5);
}

TEST(FindLesions, LooksWhereTheUserSays) {
  const auto tree = extract({straight_tube({0, 0, 0}, {3, 2, 30}, vessel(1.5, 0, 0.5, 0.2, 0.6))});
  LesionOptions options;
  options.abscissa_mm = 6.0;
  const auto lesions = find_lesions(tree, options);
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_FALSE(lesions[0].is_stenosis);
  EXPECT_EQ(lesions[0].abscissa_mm, 6.0);
  EXPECT_NEAR(lesions[0].mld_mm, 3.0, 0.05);
  options.abscissa_mm = 500.0;
  EXPECT_THROW(find_lesions(tree, options), OptionError);
  options.abscissa_mm = -1.0;
  options.centerline = 7;
  try {
    (void)find_lesions(tree, options);
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("there is one path, number 0"));
  }
}

TEST(IsUnmeasured, WhatIsBelowAVoxelOrWasKeptOpen) {
  const auto tree = extract({straight_tube({0, 0, 0}, {0, 0, 30}, vessel(1.5, 0, 0.5, 0.2, 0.6))});
  const Lesion lesion = find_lesions(tree, {}).front();
  const CenterlinePath& path = tree.paths.front();
  Resolution resolution = resolution_of_voxels({0.5, 0.5, 1.1});
  EXPECT_FALSE(is_unmeasured(lesion, path, resolution));
  resolution.narrow_lps_mm = {{0, 0, 25}, {9, 0, 15}};  // elsewhere, and in another vessel
  EXPECT_FALSE(is_unmeasured(lesion, path, resolution));
  resolution.narrow_lps_mm = {{0.2, 0, 15.5}};
  EXPECT_TRUE(is_unmeasured(lesion, path, resolution));
  EXPECT_TRUE(is_unmeasured(lesion, path, resolution_of_voxels({0.5, 0.5, 1.4})));
}

TEST(FindLesions, LeavesOutVesselsTooThinForABalloon) {
  const auto tree = extract({straight_tube({0, 0, 0}, {3, 2, 30}, vessel(1.5, 0, 0.5, 0.2, 0.6))});
  LesionOptions options;
  options.min_reference_mm = 3.5;
  const auto lesions = find_lesions(tree, options);
  EXPECT_FALSE(lesions[0].is_stenosis);
  ASSERT_EQ(lesions.size(), 2U);  // it does not go missing without a word
  EXPECT_TRUE(lesions[1].is_too_small);
  EXPECT_FALSE(lesions[1].is_too_thin);
}

TEST(FindLesions, ListsTandemLesionsApart) {
  const auto first = vessel(1.5, 0, 0.35, 0.12, 0.6), second = vessel(1.5, 0, 0.65, 0.12, 0.45);
  const auto tree = extract({straight_tube(
      {0, 0, 0}, {0, 0, 50}, [&](double t) { return std::min(first(t), second(t)); })});
  const auto lesions = find_lesions(tree, {});
  ASSERT_EQ(lesions.size(), 2U);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 60.0, 1.0);
  EXPECT_NEAR(lesions[1].diameter_stenosis_percent, 45.0, 1.0);
  // Either end may be the inlet.
  EXPECT_TRUE(lesions[0].distal_mm < lesions[1].proximal_mm ||
              lesions[1].distal_mm < lesions[0].proximal_mm);
}

TEST(FindLesions, StatesEveryReferenceEdgesAndArea) {
  // The reference at the lesion, 1.5 (1 - 0.4 t): by the line 2.28 mm at t = 0.6; the average of
  // both sides is the same, as the taper is even.
  const auto tree =
      extract({straight_tube({0, 0, 0}, {3, 2, 40}, vessel(1.5, 0.4, 0.6, 0.15, 0.5))});
  const Lesion lesion = find_lesions(tree, {}).at(0);
  EXPECT_EQ(lesion.reference_rule, "tree");
  EXPECT_EQ(lesion.reference_tree_mm, lesion.reference_diameter_mm);
  EXPECT_NEAR(lesion.reference_tree_mm, 2.28, 0.05);
  EXPECT_NEAR(lesion.reference_interpolated_mm, 2.28, 0.05);
  EXPECT_NEAR(lesion.reference_average_mm, 2.28, 0.05);
  EXPECT_NEAR(lesion.reference_average_mm,
              0.5 * (lesion.reference_proximal_mm + lesion.reference_distal_mm), 1e-12);
  EXPECT_NEAR(lesion.area_stenosis_percent, 75.0, 2.0);  // round: 1 - (1 - 0.5)^2
  EXPECT_LT(lesion.proximal_mm, lesion.abscissa_mm);
  EXPECT_GT(lesion.distal_mm, lesion.abscissa_mm);
  EXPECT_NEAR(lesion.length_mm, lesion.distal_mm - lesion.proximal_mm, 1e-12);
}

TEST(FindLesions, TakesNoEctasiaForTheReference) {
  const auto narrow = vessel(1.5, 0, 0.7, 0.12, 0.5), wide = vessel(1.5, 0, 0.35, 0.12, -0.6);
  const auto tree = extract({straight_tube(
      {0, 0, 0}, {0, 0, 50}, [&](double t) { return t < 0.5 ? wide(t) : narrow(t); })});
  const auto lesions = find_lesions(tree, {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_NEAR(lesions[0].reference_diameter_mm, 3.0, 0.05);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 50.0, 1.5);
}

TEST(FindLesions, FindsALesionAtTheOstiumOfADaughter) {
  std::vector<Tube> tubes = y_shape(0.0, 0.0);
  // Right behind the carina, which is about 5 mm from where the daughter's axis begins.
  tubes[1] = straight_tube({0, 0, 30}, {8, 0, 52}, vessel(1.5, 0.0, 0.27, 0.12, 0.6));
  const auto lesions = find_lesions(extract(tubes), {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_TRUE(lesions[0].is_stenosis);
  EXPECT_NEAR(lesions[0].mld_mm, 1.2, 0.06);
  EXPECT_NEAR(lesions[0].reference_diameter_mm, 3.0, 0.15);
}

TEST(FindLesions, InventsNoneInHealthyTrees) {
  // A quarter has an ectasia, a fifth an aneurysm, half of them noisy walls.
  for (unsigned seed = 0; seed < 30; ++seed) {
    const test::RandomTree tree = test::healthy_tree(seed);
    Volume<float> level_set = level_set_of(tree.tubes, grid_around(tree.tubes, 0.4, 1.5));
    if (seed % 2 == 1) test::add_noise(level_set, 0.06, seed);
    const auto lesions = find_lesions(extract_centerline(level_set, {}).tree, {});
    EXPECT_FALSE(lesions[0].is_stenosis) << "seed " << seed;
  }
}

}  // namespace
}  // namespace angio::centerline

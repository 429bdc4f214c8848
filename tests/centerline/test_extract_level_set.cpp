#include <gtest/gtest.h>

#include "centerline/centerline.hpp"
#include "core/error.hpp"
#include "testing/centerline/shapes.hpp"
#include "tests/centerline/tree_checks.hpp"

namespace angio::centerline {
namespace {

using test::constant;
using test::grid_around;
using test::level_set_of;
using test::make_tube;
using test::straight_tube;
using test::Tube;

/// Distance to the true middle and radius errors, away from the ends.
struct Errors {
  double mean_distance = 0.0, max_distance = 0.0;
  double mean_radius = 0.0, max_radius = 0.0;  // relative
  double mean_equivalent = 0.0;                // relative
};

Errors compare(const CenterlinePath& path, const Tube& tube) {
  Errors errors;
  int count = 0;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const auto truth = test::nearest_on(tube, path.points[i]);
    if (truth.t <= 0.02 || truth.t >= 0.98) continue;
    ++count;
    const double radius = std::abs(measured_radius(path)[i] / truth.radius - 1.0);
    errors.mean_distance += truth.distance;
    errors.max_distance = std::max(errors.max_distance, truth.distance);
    errors.mean_radius += radius;
    errors.max_radius = std::max(errors.max_radius, radius);
    errors.mean_equivalent += std::abs(path.equivalent_radius[i] / truth.radius - 1.0);
  }
  errors.mean_distance /= count;
  errors.mean_radius /= count;
  errors.mean_equivalent /= count;
  return errors;
}

TEST(CenterlineOptions, DefaultsAreValid) { EXPECT_NO_THROW(CenterlineOptions{}.validate()); }

TEST(CenterlineOptions, NamesTheBadField) {
  CenterlineOptions options;
  options.step_mm = -1.0;
  try {
    options.validate();
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_NE(std::string(error.what()).find("centerline.step_mm"), std::string::npos);
  }
}

TEST(ExtractCenterline, MeasuresAStraightTube) {
  const Tube tube = straight_tube({0, 0, 0}, {3, 2, 30}, constant(1.5));
  const auto result = extract_centerline(level_set_of({tube}, grid_around({tube}, 0.3, 1.5)), {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  EXPECT_TRUE(test::without_inlet(result.warnings).empty());
  const Errors errors = compare(result.tree.paths[0], tube);
  EXPECT_LT(errors.mean_distance, 0.005);
  EXPECT_LT(errors.max_distance, 0.03);  // a tenth of a voxel, beside the domes
  EXPECT_LT(errors.max_radius, 0.01);
  EXPECT_LT(errors.mean_equivalent, 0.002);
  // From dome to dome.
  EXPECT_NEAR(result.tree.paths[0].abscissa.back(), norm(Vec3{3, 2, 30}) + 3.0, 0.15);
}

TEST(ExtractCenterline, MeasuresATubeOfTwoVoxelsRadius) {
  const Tube tube = straight_tube({0, 0, 0}, {3, 2, 30}, constant(0.6));
  const auto result = extract_centerline(level_set_of({tube}, grid_around({tube}, 0.3, 1.5)), {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  EXPECT_LT(compare(result.tree.paths[0], tube).mean_radius, 0.01);
}

TEST(ExtractCenterline, FollowsATaper) {
  const Tube tube = straight_tube({0, 0, 0}, {3, 2, 30}, [](double t) { return 2.0 - 1.2 * t; });
  const auto result = extract_centerline(level_set_of({tube}, grid_around({tube}, 0.3, 1.5)), {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  EXPECT_LT(compare(result.tree.paths[0], tube).max_radius, 0.02);
  // The inlet is the wide end.
  EXPECT_GT(result.tree.paths[0].inscribed_radius[8], 1.8);
}

TEST(ExtractCenterline, StaysInTheMiddleOfAHelix) {
  const Tube tube = make_tube(
      [](double t) {
        return Vec3{6 * std::cos(9 * t), 6 * std::sin(9 * t), 30 * t};
      },
      constant(1.2));
  const auto result = extract_centerline(level_set_of({tube}, grid_around({tube}, 0.3, 1.5)), {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  const Errors errors = compare(result.tree.paths[0], tube);
  EXPECT_LT(errors.max_distance, 0.03);
  EXPECT_LT(errors.mean_radius, 0.01);
  EXPECT_LT(errors.mean_equivalent, 0.005);
}

TEST(ExtractCenterline, RunsToTheBorderOfTheVolume) {
  const Tube tube = straight_tube({0, 0, 0}, {0, 0, 30}, constant(1.5));
  VolumeGeometry grid = grid_around({tube}, 0.3, 1.5);
  grid.origin.z = 4.0;
  grid.size[2] = 60;  // to 4 + 59 * 0.3 = 21.7 mm
  const auto result = extract_centerline(level_set_of({tube}, grid), {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  const auto& path = result.tree.paths[0];
  EXPECT_NEAR(path.abscissa.back(), 17.7, 0.2);
  for (std::size_t i = 0; i < path.points.size(); ++i)
    EXPECT_NEAR(path.inscribed_radius[i], 1.5, 0.02);
}

TEST(ExtractCenterline, IsNotFooledByNoiseOfTheWall) {
  const Tube tube = make_tube(
      [](double t) {
        return Vec3{6 * std::cos(5 * t), 6 * std::sin(5 * t), 20 * t};
      },
      constant(1.2));
  Volume<float> level_set = level_set_of({tube}, grid_around({tube}, 0.3, 1.5));
  test::add_noise(level_set, 0.08, 7);
  const auto result = extract_centerline(level_set, {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  const Errors errors = compare(result.tree.paths[0], tube);
  EXPECT_LT(errors.mean_distance, 0.05);
  EXPECT_LT(errors.mean_radius, 0.04);
  EXPECT_LT(errors.mean_equivalent, 0.02);
}

TEST(ExtractCenterline, MovesWithThePatient) {
  const Tube tube = make_tube(
      [](double t) {
        return Vec3{8 * std::cos(3 * t), 8 * std::sin(3 * t), 10 * t};
      },
      [](double t) { return 1.6 - 0.5 * t; });
  const Mat3 turn = test::rotation({1, 2, 3}, 0.7);
  const Vec3 shift{100, -50, 30};
  Tube moved = tube;
  for (Vec3& p : moved.points) p = turn * p + shift;
  // The same voxels in another pose give the same line in that pose.
  VolumeGeometry grid = grid_around({tube}, 0.3, 1.5);
  Volume<float> level_set = level_set_of({tube}, grid);
  const auto still = extract_centerline(level_set, {});
  level_set.geometry.origin = turn * grid.origin + shift;
  level_set.geometry.direction = turn;
  const auto posed = extract_centerline(level_set, {});
  ASSERT_EQ(posed.tree.paths.size(), 1U);
  const CenterlinePath &a = still.tree.paths[0], &b = posed.tree.paths[0];
  EXPECT_NEAR(a.abscissa.back(), b.abscissa.back(), 0.1);
  for (double s = 2.0; s < a.abscissa.back() - 2.0; s += 1.0) {
    const CenterlineSample in_a = sample(a, s), in_b = sample(b, s);
    EXPECT_LT(distance(turn * in_a.point + shift, in_b.point), 0.05);
    EXPECT_NEAR(in_a.inscribed_radius, in_b.inscribed_radius, 0.02);
  }
  // Other voxels over the moved vessel give nearly the same.
  const auto resampled =
      extract_centerline(level_set_of({moved}, grid_around({moved}, 0.3, 1.5)), {});
  ASSERT_EQ(resampled.tree.paths.size(), 1U);
  EXPECT_LT(compare(resampled.tree.paths[0], moved).max_distance, 0.03);
}

TEST(ExtractCenterline, GivesTheSameTwice) {
  const Tube tube = straight_tube({0, 0, 0}, {3, 2, 20}, constant(1.2));
  const Volume<float> level_set = level_set_of({tube}, grid_around({tube}, 0.3, 1.5));
  const auto a = extract_centerline(level_set, {}), b = extract_centerline(level_set, {});
  ASSERT_EQ(a.tree.paths.size(), b.tree.paths.size());
  EXPECT_EQ(a.tree.paths[0].points, b.tree.paths[0].points);
  EXPECT_EQ(a.tree.paths[0].inscribed_radius, b.tree.paths[0].inscribed_radius);
}

TEST(ExtractCenterline, UsesTheStepThatIsAskedFor) {
  const Tube tube = straight_tube({0, 0, 0}, {0, 0, 20}, constant(1.5));
  CenterlineOptions options;
  options.step_mm = 0.5;
  const auto result =
      extract_centerline(level_set_of({tube}, grid_around({tube}, 0.3, 1.5)), options);
  const auto& s = result.tree.paths[0].abscissa;
  for (std::size_t i = 1; i < s.size(); ++i) EXPECT_NEAR(s[i] - s[i - 1], 0.5, 0.05);
}

TEST(ExtractCenterline, BeginsAtTheInletThatIsGiven) {
  const Tube tube = straight_tube({0, 0, 0}, {0, 0, 30}, [](double t) { return 2.0 - t; });
  CenterlineOptions options;
  options.inlet_lps_mm = Vec3{0, 0, 30};  // the narrow end
  const auto result =
      extract_centerline(level_set_of({tube}, grid_around({tube}, 0.3, 1.5)), options);
  ASSERT_EQ(result.tree.paths.size(), 1U);
  EXPECT_GT(result.tree.paths[0].points.front().z, 30.0);
  EXPECT_LT(result.tree.paths[0].points.back().z, 0.0);
}

TEST(ExtractCenterline, LeavesASmallPieceOutAndSaysSo) {
  const Tube large = straight_tube({0, 0, 0}, {0, 0, 30}, constant(1.5));
  const Tube small = straight_tube({8, 0, 0}, {8, 0, 10}, constant(0.5));  // 4 %
  const auto result =
      extract_centerline(level_set_of({large, small}, grid_around({large, small}, 0.3, 1.5)), {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  ASSERT_EQ(test::without_inlet(result.warnings).size(), 1U);
  EXPECT_NEAR(result.tree.paths[0].points.front().x, 0.0, 0.1);
}

TEST(ExtractCenterline, RefusesABallAndNothing) {
  const Tube ball = straight_tube({0, 0, 0}, {0, 0, 0.1}, constant(4.0));
  EXPECT_THROW(extract_centerline(level_set_of({ball}, grid_around({ball}, 0.4, 1.5)), {}),
               InputError);
  VolumeGeometry grid;
  grid.size = {10, 10, 10};
  EXPECT_THROW(extract_centerline(Volume<float>(grid, 1.0F), {}), InputError);
}

}  // namespace
}  // namespace angio::centerline

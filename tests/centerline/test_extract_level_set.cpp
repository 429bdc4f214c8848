#include <gtest/gtest.h>

#include "centerline/centerline.hpp"
#include "core/error.hpp"
#include "tests/centerline/shapes.hpp"

namespace angio::centerline {
namespace {

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
    const double radius = std::abs(path.inscribed_radius[i] / truth.radius - 1.0);
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

std::function<double(double)> constant(double radius) {
  return [radius](double) { return radius; };
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
  EXPECT_TRUE(result.warnings.empty());
  const Errors errors = compare(result.tree.paths[0], tube);
  EXPECT_LT(errors.max_distance, 0.01);
  EXPECT_LT(errors.max_radius, 0.005);
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

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "centerline/centerline.hpp"
#include "meshing/detail/isosurface.hpp"
#include "testing/centerline/shapes.hpp"
#include "tests/centerline/tree_checks.hpp"

namespace angio::centerline {
namespace {

using test::constant;
using test::expect_consistent;
using test::extract;
using test::make_tube;
using test::straight_tube;
using test::Tube;

bool warns_of(const CenterlineResult& result, const std::string& what, const std::string& where) {
  return std::any_of(result.warnings.begin(), result.warnings.end(), [&](const std::string& text) {
    return text.find(what) != std::string::npos && text.find(where) != std::string::npos;
  });
}
TEST(CenterlineTree, CoversALoopAndWarns) {
  const Tube ring = make_tube(
      [](double t) {
        return Vec3{10 * std::cos(2 * units::kPi * t), 10 * std::sin(2 * units::kPi * t), 0.0};
      },
      constant(1.5));
  const std::vector<Tube> tubes{ring, straight_tube({-10, 0, 0}, {-30, 0, 0}, constant(2.0)),
                                straight_tube({10, 0, 0}, {25, 3, 0}, constant(1.2))};
  const auto result = extract(tubes);
  expect_consistent(result.tree);
  ASSERT_EQ(test::without_inlet(result.warnings).size(), 1U);
  EXPECT_TRUE(warns_of(result, "loop", "cut at ("));
  for (const Vec3& p : ring.points) {
    double nearest = 1e9;
    for (const auto& path : result.tree.paths)
      for (const Vec3& q : path.points) nearest = std::min(nearest, distance(p, q));
    EXPECT_LT(nearest, 3.0) << p.x << ' ' << p.y;
  }
}

TEST(CenterlineTree, KeepsTouchingVesselsApart) {
  // A hairpin whose legs are less than a voxel apart: the line must go round the bend.
  const Tube hairpin = make_tube(
      [](double t) {
        const double x = 2.2 * std::cos(units::kPi * std::clamp(3 * t - 1, 0.0, 1.0));
        const double y = 2.2 * std::sin(units::kPi * std::clamp(3 * t - 1, 0.0, 1.0));
        const double leg =
            t < 1.0 / 3 ? 60 * (1.0 / 3 - t) : (t > 2.0 / 3 ? 60 * (t - 2.0 / 3) : 0);
        return Vec3{x, y - leg, 0.0};
      },
      constant(2.05));
  const auto result = extract({hairpin});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  EXPECT_GT(result.tree.paths[0].abscissa.back(), 40.0);
}

TEST(CenterlineTree, RunsRoundAHairpinWhoseLegsTouch) {
  // A loop of a wide vessel; its legs, half a diameter apart, are bridged by a narrow neck.
  const Tube hairpin = make_tube(
      [](double t) {
        const double angle = units::kPi * std::clamp(3 * t - 1, 0.0, 1.0);
        const double leg =
            t < 1.0 / 3 ? 90 * (1.0 / 3 - t) : (t > 2.0 / 3 ? 90 * (t - 2.0 / 3) : 0);
        return Vec3{3.0 * std::cos(angle), 3.0 * std::sin(angle) - leg, 0.0};
      },
      constant(2.0));
  const auto result = extract({hairpin, straight_tube({-3, -20, 0}, {3, -20, 0}, constant(0.8))});
  EXPECT_TRUE(warns_of(result, "loop", "cut at ("));
  ASSERT_EQ(result.tree.paths.size(), 1U);
  EXPECT_GT(result.tree.paths[0].abscissa.back(), 60.0);
}

/// A wide vessel along z and a thin one beside it, their walls a gap apart (below zero: merged).
std::vector<Tube> crossing_vessels(double degrees, double gap) {
  const double angle = degrees * units::kPi / 180.0, aside = 1.5 + 0.9 + gap;
  const Vec3 along{0.0, std::sin(angle), std::cos(angle)}, middle{aside, 0.0, 0.0};
  return {straight_tube({0, 0, -20}, {0, 0, 20}, constant(1.5)),
          straight_tube(middle - 20.0 * along, middle + 20.0 * along, constant(0.9))};
}

TEST(CenterlineTree, NamesThePlaceWhereCrossingVesselsTouch) {
  for (const double degrees : {30.0, 60.0, 90.0}) {
    const auto result = extract(crossing_vessels(degrees, -0.3));
    EXPECT_EQ(result.tree.paths.size(), 3U) << degrees;
    EXPECT_TRUE(warns_of(result, "seem to touch", "at (0, 0, ")) << degrees;
    // The wide vessel's own line runs through, from end to end.
    EXPECT_TRUE(std::any_of(result.tree.paths.begin(), result.tree.paths.end(), [](const auto& p) {
      return std::abs(p.points.front().z - p.points.back().z) > 39.0;
    })) << degrees;
  }
}

TEST(CenterlineTree, DoesNotJoinCrossingVesselsHalfAVoxelApart) {
  const auto result = extract(crossing_vessels(60.0, 0.15));
  EXPECT_EQ(result.tree.paths.size(), 2U);
  EXPECT_EQ(result.tree_count, 2);
}

TEST(CenterlineTree, NamesVesselsThatRunSideBySideAsOne) {
  // From what overlaps by little to two thirds of a radius; alike and unlike.
  for (const auto& [radius, apart] : {std::pair{1.5, 2.7}, {1.5, 2.0}, {1.0, 2.2}}) {
    const auto result = extract({straight_tube({0, 0, -15}, {0, 0, 15}, constant(1.5)),
                                 straight_tube({apart, 0, -15}, {apart, 0, 15}, constant(radius))});
    EXPECT_TRUE(warns_of(result, "side by side", "")) << radius << " " << apart;
  }
}

TEST(CenterlineTree, OfASurfaceIsToldInWordsOfSurfaces) {
  const std::vector<Tube> tubes{straight_tube({0, 0, -15}, {0, 0, 15}, constant(1.5)),
                                straight_tube({2.2, 0, -15}, {2.2, 0, 15}, constant(1.5)),
                                straight_tube({9, 0, -4}, {9, 0, 4}, constant(1.0))};
  const Volume<float> level_set = test::level_set_of(tubes, test::grid_around(tubes, 0.3, 1.5));
  const auto of_image = extract_centerline(level_set, {});
  EXPECT_TRUE(warns_of(of_image, "side by side", "finer voxels may part them"));
  const auto result = extract_centerline(meshing::detail::extract_isosurface(level_set), {});
  EXPECT_TRUE(warns_of(result, "side by side", "; a surface of one of them"));
  EXPECT_TRUE(warns_of(result, "separate pieces", "% of the lumen)"));
  for (const char* word : {"voxel", "image", "scan", "segmentation"})
    EXPECT_FALSE(warns_of(result, word, "")) << word;
}

TEST(CenterlineTree, NamesAHairpinWhoseLegsTouch) {
  const Tube hairpin = make_tube(
      [](double t) {
        const double turn = units::kPi * std::clamp(3 * t - 1, 0.0, 1.0);
        const double leg = t < 1.0 / 3 ? 60 * (1.0 / 3 - t) : std::max(60 * (t - 2.0 / 3), 0.0);
        return Vec3{1.7 * std::cos(turn), 1.7 * std::sin(turn) - leg, 0.0};
      },
      constant(1.9));
  EXPECT_TRUE(warns_of(extract({hairpin}), "side by side", ""));
}

TEST(CenterlineTree, OfAClosedRingIsCutWithAWarning) {
  const Tube ring = make_tube(
      [](double t) {
        return Vec3{10 * std::cos(2 * units::kPi * t), 10 * std::sin(2 * units::kPi * t), 0.0};
      },
      constant(1.5));
  const auto result = extract({ring});
  expect_consistent(result.tree);
  EXPECT_EQ(test::without_inlet(result.warnings).size(), 1U);
}

}  // namespace
}  // namespace angio::centerline

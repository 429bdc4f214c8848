#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "centerline/centerline.hpp"
#include "core/centerline_trees.hpp"
#include "core/error.hpp"
#include "tests/centerline/tree_checks.hpp"

/// A lumen in several pieces, as the left and the right carotid.
namespace angio::centerline {
namespace {

using test::constant;
using test::expect_consistent;
using test::extract;
using test::grid_around;
using test::level_set_of;
using test::straight_tube;
using test::Tube;

/// A fork, and beside it, 12 mm away, a shorter vessel.
std::vector<Tube> fork_and_tube() {
  std::vector<Tube> tubes = test::y_shape();
  tubes.push_back(straight_tube({24, 0, 0}, {24, 0, 30}, [](double t) { return 1.6 - 0.3 * t; }));
  return tubes;
}

CenterlineResult lines_of(const std::vector<Tube>& tubes, const CenterlineOptions& options) {
  return extract_centerline(level_set_of(tubes, grid_around(tubes, 0.3, 1.5)), options);
}

TEST(SeveralTrees, HaveLinesAndAnInletEach) {
  const auto result = extract(fork_and_tube());
  EXPECT_EQ(result.tree_count, 2);
  ASSERT_EQ(result.tree.paths.size(), 3U);
  EXPECT_NEAR(result.left_out, 0.0, 1e-12);
  EXPECT_THAT(tree_of_paths(result.tree), testing::ElementsAre(0, 0, 1));
  for (const CenterlineTree& tree : separate_trees(result.tree)) {
    std::set<int> groups;
    for (const CenterlinePath& path : tree.paths)
      for (const CenterlineTract& tract : path.tracts) groups.insert(tract.group_id);
    for (const CenterlineTree& other : separate_trees(result.tree))
      if (other.paths.front().id != tree.paths.front().id) {
        for (const CenterlinePath& path : other.paths)
          for (const CenterlineTract& tract : path.tracts)
            EXPECT_FALSE(groups.contains(tract.group_id)) << tract.group_id;
      }
  }
  expect_consistent(result.tree);
  const CenterlinePath& beside = result.tree.paths[2];
  for (const Vec3& p : beside.points) EXPECT_NEAR(p.x, 24.0, 0.2);
  EXPECT_LT(beside.points.front().z, beside.points.back().z) << "it begins where it is wide";
}

TEST(SeveralTrees, AreThoseThatTheyAreAlone) {
  const std::vector<Tube> tubes = fork_and_tube();
  const auto together = extract(tubes);
  const Volume<float> alone = level_set_of({tubes.back()}, grid_around(tubes, 0.3, 1.5));
  const CenterlinePath expected = extract_centerline(alone, {}).tree.paths.front();
  ASSERT_EQ(together.tree.paths.size(), 3U);
  const CenterlinePath& found = together.tree.paths[2];
  EXPECT_EQ(found.points, expected.points);
  EXPECT_EQ(found.inscribed_radius, expected.inscribed_radius);
}

TEST(SeveralTrees, TakeANamedInletWhereItLies) {
  CenterlineOptions options;
  options.inlet_lps_mm = Vec3{24, 0, 30};
  const auto result = lines_of(fork_and_tube(), options);
  ASSERT_EQ(result.tree.paths.size(), 3U);
  EXPECT_GT(result.tree.paths[2].points.front().z, 25.0);
  EXPECT_LT(result.tree.paths[0].points.front().z, 5.0) << "the other tree's own rule";
}

TEST(SeveralTrees, WithoutANamedOutletHaveNoLines) {
  CenterlineOptions options;
  options.outlets_lps_mm = {{24, 0, 30}};
  const auto result = lines_of(fork_and_tube(), options);
  ASSERT_EQ(result.tree.paths.size(), 1U);
  EXPECT_NEAR(result.tree.paths[0].points.back().x, 24.0, 0.3);
  EXPECT_GT(result.left_out, 0.5);
}

TEST(SeveralTrees, CrumbsAndStumpsAreNone) {
  std::vector<Tube> tubes = fork_and_tube();
  tubes.back() = straight_tube({24, 0, 0}, {24, 0, 6}, constant(2.0));  // hardly longer than wide
  EXPECT_EQ(extract(tubes).tree_count, 1);
  tubes.back() = straight_tube({24, 0, 0}, {24, 0, 12}, constant(0.5));  // 4 % of the fork
  EXPECT_EQ(extract(tubes).tree_count, 1);
}

TEST(SeveralTrees, AreAllSearchedForStenoses) {
  std::vector<Tube> tubes = fork_and_tube();
  tubes.back() = straight_tube({24, 0, 0}, {24, 0, 36}, [](double t) {
    const double x = (t - 0.5) / 0.12;
    return std::abs(x) < 1.0 ? 1.5 * (1.0 - 0.3 * (1.0 + std::cos(units::kPi * x))) : 1.5;
  });
  const CenterlineTree lines = extract(tubes).tree;
  ASSERT_EQ(lines.paths.size(), 3U);
  const std::vector<Lesion> lesions = find_lesions(lines, {});
  ASSERT_TRUE(lesions.front().is_stenosis);
  EXPECT_EQ(lesions.front().path_id, 2);
  EXPECT_NEAR(lesions.front().diameter_stenosis_percent, 60.0, 5.0);
  LesionOptions on_line;
  on_line.centerline = 2;
  EXPECT_EQ(find_lesions(lines, on_line).front().path_id, 2);
  on_line.centerline = 0;
  EXPECT_FALSE(find_lesions(lines, on_line).front().is_stenosis);
}

TEST(SeveralTrees, WithoutAStenosisGiveTheTightestPlaceOfTheFirst) {
  const std::vector<Lesion> lesions = find_lesions(extract(fork_and_tube()).tree, {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_FALSE(lesions.front().is_stenosis);
  EXPECT_EQ(lesions.front().path_id, 0);
}

TEST(TreeWithPath, IsEmptyWhereNoneHasIt) {
  const CenterlineTree lines = extract(fork_and_tube()).tree;
  EXPECT_EQ(tree_with_path(lines, 1).paths.size(), 2U);
  EXPECT_EQ(tree_with_path(lines, 2).paths.size(), 1U);
  EXPECT_TRUE(tree_with_path(lines, 3).paths.empty());
}

/// Behind a wide vessel's cut face a thin one leaves it and runs along the border: from its tip
/// nothing of the face stands out.
TEST(BorderSections, AreEndsThoughNothingStandsOut) {
  const auto image = [](const Vec3& p) {
    const double wide = std::hypot(p.x, p.y) - 3.0;
    const double along = std::clamp(p.x, 0.0, 17.0);
    const double thin = norm(p - Vec3{along, 0.0, 1.2}) - 0.9;
    const double end = std::max(wide, p.z - 36.0);
    return std::min(end, thin);
  };
  VolumeGeometry grid;
  grid.size = {80, 40, 140};
  grid.spacing = {0.3, 0.3, 0.3};
  grid.origin = {-4.03, -6.01, 0.0};
  Volume<float> level_set(grid);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        level_set.at(i, j, k) =
            float(image(grid.lps_from_index({double(i), double(j), double(k)})));
  const auto result = extract_centerline(level_set, {});
  ASSERT_EQ(result.tree.paths.size(), 2U);
  EXPECT_LT(norm(result.tree.paths[0].points.front()), 2.0) << "the wide vessel's face";
}

/// A vessel of 5 mm that bends out of the data, which end at x = border, and comes back.
CenterlineResult bend_beyond(double border) {
  constexpr double kRadius = 2.5, kOut = 3.0;
  const auto axis = [](double z) {
    const double t = (z - 30.0) / 15.0;
    return std::abs(t) < 1.0 ? -0.5 * kOut * (1.0 + std::cos(units::kPi * t)) : 0.0;
  };
  VolumeGeometry grid;
  grid.spacing = {0.3, 0.3, 0.3};
  grid.origin = {border, -4.51, 0.0};
  grid.size = {int((4.5 - border) / 0.3), 31, 201};
  Volume<float> level_set(grid);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = grid.lps_from_index({double(i), double(j), double(k)});
        double nearest = 1e9;
        for (double z = p.z - 5.0; z < p.z + 5.0; z += 0.1)
          nearest = std::min(nearest, norm(p - Vec3{axis(z), 0.0, z}));
        level_set.at(i, j, k) = float(nearest - kRadius);
      }
  return extract_centerline(level_set, {});
}

TEST(BorderSections, AlongAVesselAreNotMeasured) {
  const auto blanked = [](const CenterlineResult& result) {
    double length = 0.0;
    for (const CenterlinePath& path : result.tree.paths)
      for (const CenterlineTract& tract : path.tracts)
        if (tract.blanking)
          length += path.abscissa[std::size_t(tract.last_point)] -
                    path.abscissa[std::size_t(tract.first_point)];
    return length;
  };
  const CenterlineResult whole = bend_beyond(-8.0), cut = bend_beyond(-2.7);
  EXPECT_EQ(blanked(whole), 0.0);
  EXPECT_GT(blanked(cut), 8.0);
  EXPECT_LT(blanked(cut), 40.0);
  const auto tells = [](const std::string& note) {
    return note.find("border of the data") != std::string::npos;
  };
  EXPECT_TRUE(std::any_of(cut.warnings.begin(), cut.warnings.end(), tells));
  for (const Lesion& lesion : find_lesions(cut.tree, {})) EXPECT_FALSE(lesion.is_stenosis);
}

}  // namespace
}  // namespace angio::centerline

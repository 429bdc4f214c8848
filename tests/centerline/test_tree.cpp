#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "centerline/centerline.hpp"
#include "centerline/detail/lumen_voxels.hpp"
#include "centerline/detail/places.hpp"
#include "centerline/detail/short_branches.hpp"
#include "centerline/detail/tracts.hpp"
#include "tests/centerline/straight_lines.hpp"
#include "tests/centerline/tree_checks.hpp"

namespace angio::centerline {
namespace {

using test::constant;
using test::expect_consistent;
using test::extract;
using test::grid_around;
using test::level_set_of;
using test::straight_tube;
using test::Tube;
using test::y_shape;

TEST(CenterlineTree, OfAYHasTwoPathsThatShareTheirTrunk) {
  const auto result = extract(y_shape());
  ASSERT_EQ(result.tree.paths.size(), 2U);
  expect_consistent(result.tree);
  const auto &a = result.tree.paths[0], &b = result.tree.paths[1];
  std::size_t shared = 0;
  while (a.points[shared] == b.points[shared]) ++shared;
  EXPECT_NEAR(a.points[shared].z, 20.0, 4.0);
  for (std::size_t i = 0; i < shared; ++i) {
    EXPECT_EQ(a.inscribed_radius[i], b.inscribed_radius[i]);
    EXPECT_EQ(a.section_area[i], b.section_area[i]);
  }
}

TEST(CenterlineTree, OfAYHasThreeBranchesAndOneBranching) {
  const auto result = extract(y_shape());
  ASSERT_EQ(result.tree.paths.size(), 2U);
  const auto &a = result.tree.paths[0].tracts, &b = result.tree.paths[1].tracts;
  ASSERT_EQ(a.size(), 3U);
  ASSERT_EQ(b.size(), 3U);
  for (const auto& tracts : {a, b}) {
    EXPECT_FALSE(tracts[0].blanking);
    EXPECT_TRUE(tracts[1].blanking);
    EXPECT_FALSE(tracts[2].blanking);
  }
  EXPECT_EQ(a[0].group_id, b[0].group_id);
  EXPECT_EQ(a[1].group_id, b[1].group_id);
  EXPECT_NE(a[2].group_id, b[2].group_id);
  EXPECT_EQ(a[0].last_point, b[0].last_point);
}

TEST(CenterlineTree, LeavesTheTubeOfTheOtherBranchAtTheEndOfTheBranching) {
  const auto result = extract(y_shape());
  for (int which = 0; which < 2; ++which) {
    const CenterlinePath& path = result.tree.paths[std::size_t(which)];
    const CenterlinePath& other = result.tree.paths[std::size_t(1 - which)];
    for (int i = path.tracts[2].first_point; i <= path.tracts[2].last_point; ++i)
      for (std::size_t m = 0; m < other.points.size(); ++m)
        EXPECT_GE(distance(path.points[std::size_t(i)], other.points[m]),
                  other.inscribed_radius[m]);
  }
}

TEST(CenterlineTree, FindsASideBranchAtARightAngle) {
  const std::vector<Tube> tubes{straight_tube({0, 0, 0}, {0, 0, 40}, constant(2.0)),
                                straight_tube({0, 0, 20}, {18, 0, 20}, constant(0.8))};
  const auto result = extract(tubes);
  ASSERT_EQ(result.tree.paths.size(), 2U);
  expect_consistent(result.tree);
  for (std::size_t i = 0; i < result.tree.paths[1].points.size(); ++i) {
    const Vec3& p = result.tree.paths[1].points[i];
    if (p.x > 4.0 && p.x < 17.5) {  // in the dome beyond, the radius is the distance to the dome
      EXPECT_NEAR(result.tree.paths[1].inscribed_radius[i], 0.8, 0.3);
    }
  }
}

TEST(CenterlineTree, InventsNoBranchesInNoise) {
  EXPECT_EQ(extract(y_shape(), 0.1).tree.paths.size(), 2U);
  const Tube wide = straight_tube({0, 0, 0}, {5, 0, 30}, constant(3.0));
  EXPECT_EQ(extract({wide}, 0.15).tree.paths.size(), 1U);
}

TEST(CenterlineTree, InventsNoBranchesAtTheEdgesOfFlatCaps) {
  const Tube tube = straight_tube({0, 0, -5}, {0, 0, 35}, constant(3.0));
  const auto result =
      extract_centerline(level_set_of({tube}, grid_around({tube}, 0.4, 1.5),
                                      {{{0, 0, 1}, 28.0}, {normalized(Vec3{0.3, 0, -0.95}), -2.0}}),
                         {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  for (const Vec3& p : result.tree.paths[0].points) EXPECT_LT(std::hypot(p.x, p.y), 0.3);
}

TEST(CenterlineTree, LinesRunStraightIntoObliqueCaps) {
  const double radius = 3.0;
  const Tube tube = straight_tube({0, 0, -15}, {0, 0, 45}, constant(radius));
  for (const double degrees : {20.0, 30.0, 45.0}) {
    const double sine = std::sin(degrees * units::kPi / 180.0),
                 cosine = std::cos(degrees * units::kPi / 180.0);
    const auto result = extract_centerline(
        level_set_of({tube}, grid_around({tube}, 0.4, 1.5),
                     {{{sine, 0, cosine}, 28.0 * cosine}, {{0, sine, -cosine}, -2.0 * cosine}}),
        {});
    ASSERT_EQ(result.tree.paths.size(), 1U) << degrees;
    const CenterlinePath& path = result.tree.paths[0];
    double most = 0.0;
    for (const Vec3& p : path.points) most = std::max(most, std::hypot(p.x, p.y));
    EXPECT_LT(most, 0.2 * radius) << degrees;
    // The axis meets the caps' planes at z = 28 and z = 2.
    EXPECT_NEAR(path.abscissa.back(), 26.0, 0.4 * radius) << degrees;
  }
}

TEST(CenterlineTree, InventsNoBranchForAStub) {
  // The stub stands out by half the vessel's diameter.
  const std::vector<Tube> tubes{straight_tube({0, 0, 0}, {0, 0, 40}, constant(2.0)),
                                straight_tube({0, 0, 20}, {3.2, 0, 20}, constant(0.8))};
  EXPECT_EQ(extract(tubes).tree.paths.size(), 1U);
}

/// The ends of the lines, the inlet too, that lie within a reach [mm] of a place.
int count_ends_near(const CenterlineTree& tree, const Vec3& place, double reach) {
  int count = distance(tree.paths.front().points.front(), place) < reach ? 1 : 0;
  for (const CenterlinePath& path : tree.paths)
    count += distance(path.points.back(), place) < reach ? 1 : 0;
  return count;
}

TEST(CenterlineTree, TakesTheStumpOfAVesselBehindAForkForAnEnd) {
  // A wide vessel, cut off one of its diameters behind a side branch, with a round end or a flat
  // one.
  const std::vector<Tube> tubes{straight_tube({0, 0, -35}, {0, 0, 6}, constant(6.0)),
                                straight_tube({0, 0, 0}, {40, 0, 8}, constant(2.4))};
  for (const bool is_flat : {false, true}) {
    std::vector<test::Cut> cuts;
    if (is_flat) cuts.push_back({{0, 0, 1}, 11.0});
    const auto result =
        extract_centerline(level_set_of(tubes, grid_around(tubes, 0.8, 2.0), cuts), {});
    ASSERT_EQ(result.tree.paths.size(), 2U) << is_flat;
    EXPECT_EQ(count_ends_near(result.tree, {0, 0, 11}, 6.0), 1) << is_flat;
    EXPECT_EQ(count_ends_near(result.tree, {0, 0, -41}, 6.0), 1) << is_flat;
  }
}

TEST(CenterlineTree, InventsNoEndInTheCornerOfABend) {
  for (const double beyond : {0.0, 2.0, 4.0}) {
    const std::vector<Tube> tubes{straight_tube({0, 0, -40}, {0, 0, beyond}, constant(6.0)),
                                  straight_tube({0, 0, 0}, {40, 0, 0}, constant(6.0))};
    const auto result = extract_centerline(level_set_of(tubes, grid_around(tubes, 0.8, 2.0)), {});
    EXPECT_EQ(result.tree.paths.size(), 1U) << beyond;
  }
}

TEST(CenterlineTree, InventsNoEndInABulgeAsWideAsItsVessel) {
  const std::vector<Tube> tubes{straight_tube({0, 0, -35}, {0, 0, 35}, constant(5.0)),
                                straight_tube({0, 0, 0}, {6, 0, 0}, constant(5.0))};
  const auto result = extract_centerline(level_set_of(tubes, grid_around(tubes, 0.7, 2.0)), {});
  EXPECT_EQ(result.tree.paths.size(), 1U);
}

TEST(CenterlineTree, KeepsTheLineOfAThinTubeShorterThanItsParentIsWide) {
  // It stands out by two thirds of the wide vessel's diameter: two and a half times its own.
  const std::vector<Tube> tubes{straight_tube({0, 0, -25}, {0, 0, 25}, constant(3.0)),
                                straight_tube({0, 0, 0}, {6.2, 0, 0}, constant(0.8))};
  EXPECT_EQ(extract(tubes).tree.paths.size(), 2U);
}

TEST(CenterlineTree, KeepsTheLineOfAShortBranchWhoseMouthIsWide) {
  // It stands out by less than the wide vessel's diameter; its mouth is twice as wide as the rest
  // of it.
  const auto funnel = [](double t) { return 1.6 - 0.8 * std::clamp(5.0 * (t - 0.4), 0.0, 1.0); };
  const std::vector<Tube> tubes{straight_tube({0, 0, -30}, {0, 0, 30}, constant(4.0)),
                                straight_tube({0, 0, 0}, {9.2, 0, 0}, funnel)};
  const auto result = extract(tubes);
  ASSERT_EQ(result.tree.paths.size(), 2U);
  EXPECT_EQ(count_ends_near(result.tree, {10, 0, 0}, 1.0), 1);
}

TEST(CenterlineTree, FollowsAVesselToItsEndBehindASac) {
  // Seen from its tip the vessel widens into the sac as fast as if all of it were the sac's cap,
  // and the sac's axis meets a wall, because the vessel leaves it at 60 degrees.
  constexpr double kLength = 90.0, kBend = 36.0;
  const auto to_tip = [](double t) { return kLength * (1.0 - t); };
  const auto radius = [&](double t) {
    const double x = to_tip(t);
    if (x < 8.0) return 3.0 + 0.03 * x;
    return x < 60.0 ? std::min(3.24 + 0.3 * (x - 8.0), 10.0) : 5.0;
  };
  const Vec3 aside{std::sin(units::kPi / 3.0), 0, std::cos(units::kPi / 3.0)};
  const auto axis = [&](double t) {
    return std::max(kBend - to_tip(t), 0.0) * aside + Vec3{0, 0, std::min(kBend - to_tip(t), 0.0)};
  };
  const std::vector<Tube> tubes{test::make_tube(axis, radius)};
  const auto result = extract_centerline(level_set_of(tubes, grid_around(tubes, 0.8, 2.0)), {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  EXPECT_EQ(count_ends_near(result.tree, (kBend + 3.0) * aside, 2.0), 1);
}

std::size_t count_sacs(const CenterlineResult& result) {
  return std::size_t(std::count_if(
      result.warnings.begin(), result.warnings.end(),
      [](const std::string& text) { return text.find("a sac") != std::string::npos; }));
}

TEST(CenterlineTree, RunsPastASacAndNamesIt) {
  for (const double noise : {0.0, 0.05}) {
    const auto result = extract({straight_tube({0, 0, 0}, {0, 0, 30}, constant(1.5)),
                                 straight_tube({0, 0, 15}, {4.5, 0, 15}, constant(1.05)),
                                 straight_tube({4.9, 0, 15}, {5.1, 0, 15}, constant(3.0))},
                                noise);
    EXPECT_EQ(result.tree.paths.size(), 1U);
    EXPECT_EQ(count_sacs(result), 1U);
  }
}

TEST(CenterlineTree, RunsPastASacThatIsTwiceAsLongAsWide) {
  // Wider than the vessel that it sits on: no branch.
  const auto result = extract({straight_tube({0, 0, 0}, {0, 0, 30}, constant(1.2)),
                               straight_tube({0, 0, 15}, {3.5, 0, 15}, constant(1.0)),
                               straight_tube({4, 0, 15}, {8, 0, 15}, constant(2.0))});
  EXPECT_EQ(result.tree.paths.size(), 1U);
  EXPECT_EQ(count_sacs(result), 1U);
}

TEST(Sac, WithoutANarrowMouthIsOneWhereTheOtherVesselsAreCutOffFlat) {
  // A blind branch of 2.1 mm on a vessel of 1.5, or of 1.3, on which it may be a vessel.
  for (const double radius : {2.1, 1.3}) {
    const std::vector<Tube> tubes{straight_tube({0, 0, 0}, {0, 0, 30}, constant(1.5)),
                                  straight_tube({1.5, 0, 15}, {7, 0, 15}, constant(radius))};
    const auto lumen =
        find_lumen_pieces(level_set_of(tubes, grid_around(tubes, 0.3, 1.5))).pieces.front();
    std::vector<int> own;
    for (double x = 7.0 + radius - 0.3; x > 0.2; x -= 0.3) own.push_back(lumen.nearest({x, 0, 15}));
    const int junction = lumen.nearest({0, 0, 15});
    EXPECT_FALSE(is_sac(lumen, own, junction, false)) << radius;
    EXPECT_EQ(is_sac(lumen, own, junction, true), radius > 1.5) << radius;
  }
}

TEST(CenterlineTree, KeepsTheLineOfAShortBranchThatDoesNotWiden) {
  const auto taper = [](double t) { return 1.0 - 0.2 * t; };
  for (const double noise : {0.0, 0.05}) {
    const auto result = extract({straight_tube({0, 0, 0}, {0, 0, 30}, constant(1.5)),
                                 straight_tube({0, 0, 15}, {5.5, 0, 15}, taper)},
                                noise);
    EXPECT_EQ(result.tree.paths.size(), 2U);
    EXPECT_EQ(count_sacs(result), 0U);
  }
}

TEST(CenterlineTree, KeepsTheLineOfAVesselThatLeavesASac) {
  const auto result = extract({straight_tube({0, 0, 0}, {0, 0, 30}, constant(1.5)),
                               straight_tube({0, 0, 15}, {4.5, 0, 15}, constant(1.05)),
                               straight_tube({4.9, 0, 15}, {5.1, 0, 15}, constant(3.0)),
                               straight_tube({5, 0, 15}, {20, 0, 15}, constant(1.0))});
  EXPECT_EQ(result.tree.paths.size(), 2U);
}

TEST(CenterlineTree, BeginsAtTheTrunkThoughItsTwigsRunBack) {
  // Their forks look as if the blood came from the other side: the widths of all ends tell.
  const Vec3 fork{0, 0, 25}, along = normalized(Vec3{10, 0, 35});
  std::vector<Tube> tubes{straight_tube({0, 0, 0}, fork, constant(1.25)),
                          straight_tube(fork, fork + 42.0 * along, constant(0.9)),
                          straight_tube(fork, {-12, 0, 42}, constant(0.8))};
  for (const double at : {12.0, 22.0, 32.0}) {
    const Vec3 from = fork + at * along, back = normalized(Vec3{0, 1, 0} - along);
    tubes.push_back(straight_tube(from, from + 8.0 * back, constant(0.45)));
  }
  const auto result = extract(tubes);
  ASSERT_EQ(result.tree.paths.size(), 5U);
  EXPECT_LT(distance(result.tree.paths[0].points.front(), {0, 0, 0}), 2.0);
}

TEST(CenterlineTree, TakesANarrowBranchingForABranching) {
  const auto result = extract({straight_tube({0, 0, -15}, {0, 0, 0}, constant(2.0)),
                               straight_tube({0, 0, 0}, {4.2, 0, 24}, constant(1.5)),
                               straight_tube({0, 0, 0}, {-4.2, 0, 24}, constant(1.5))});
  EXPECT_EQ(result.tree.paths.size(), 2U);
  EXPECT_TRUE(test::without_inlet(result.warnings).empty());
}

TEST(CenterlineTree, TakesOppositeBranchesForBranches) {
  const auto result = extract({straight_tube({0, 0, -20}, {0, 0, 20}, constant(2.5)),
                               straight_tube({0, 0, 0}, {15, 0, 4}, constant(1.0)),
                               straight_tube({0, 0, 1}, {-15, 0, 5}, constant(1.0))});
  EXPECT_EQ(result.tree.paths.size(), 3U);
  EXPECT_TRUE(test::without_inlet(result.warnings).empty());
}

TEST(CenterlineTree, OfATrifurcationHasOneBranchingWithThreeDaughters) {
  // VMTK's convention: each line has the tracts 0, 1, 2, blanked in the branching; trunk and
  // branching are one group each for all lines, every daughter is a group of its own.
  const std::vector<Tube> tubes{straight_tube({0, 0, 0}, {0, 0, 20}, constant(2.0)),
                                straight_tube({0, 0, 20}, {12, 0, 38}, constant(1.4)),
                                straight_tube({0, 0, 20}, {-12, 1, 37}, constant(1.3)),
                                straight_tube({0, 0, 20}, {0, 12, 37.5}, constant(1.2))};
  const auto result = extract(tubes);
  ASSERT_EQ(result.tree.paths.size(), 3U);
  expect_consistent(result.tree);
  std::set<int> trunks, branchings, daughters;
  for (const CenterlinePath& path : result.tree.paths) {
    ASSERT_EQ(path.tracts.size(), 3U);
    EXPECT_FALSE(path.tracts[0].blanking);
    EXPECT_TRUE(path.tracts[1].blanking);
    EXPECT_FALSE(path.tracts[2].blanking);
    trunks.insert(path.tracts[0].group_id);
    branchings.insert(path.tracts[1].group_id);
    daughters.insert(path.tracts[2].group_id);
  }
  EXPECT_EQ(trunks.size(), 1U);
  EXPECT_EQ(branchings.size(), 1U);
  EXPECT_EQ(daughters.size(), 3U);
}

/// A line of 8 mm, narrowed by 90 % in its middle, that sees no tube within some mm of it.
CenterlineTree blind_in_its_throat(double mm, double depth, std::vector<std::string>& notes) {
  const auto diameter = [=](double s) { return 8.0 * test::narrowed(s, 50.0, 12.0, depth); };
  CenterlineTree tree = test::tree_of({test::line_of(diameter, 100.0)});
  std::vector<char> is_tube;
  for (const Vec3& point : tree.paths[0].points)
    is_tube.push_back(std::abs(point.z - 50.0) > mm ? 1 : 0);
  notes = assign_tracts(tree, {is_tube});
  return tree;
}

TEST(Tracts, AreBlankedWhereALongStretchIsNoTubeButNotInAShortThroat) {
  std::vector<std::string> notes;
  EXPECT_EQ(blind_in_its_throat(2.0, 0.9, notes).paths[0].tracts.size(), 1U);
  EXPECT_TRUE(notes.empty());
  EXPECT_EQ(blind_in_its_throat(5.0, 0.0, notes).paths[0].tracts.size(), 1U);  // under 3 radii
  const CenterlineTree blind = blind_in_its_throat(8.0, 0.0, notes);
  ASSERT_EQ(blind.paths[0].tracts.size(), 3U);
  EXPECT_TRUE(blind.paths[0].tracts[1].blanking);
  EXPECT_EQ(notes.size(), 1U);
}

TEST(Places, AreOneNoteHoweverMany) {
  const auto row = [](int count) {
    std::vector<Vec3> places;
    for (int i = 0; i < count; ++i) places.push_back({double(i), 0.0, 0.4});
    return places;
  };
  EXPECT_EQ(at_places(row(1)), "at (0, 0, 0) mm");
  EXPECT_EQ(at_places(row(2)), "at (0, 0, 0) mm and (1, 0, 0) mm");
  EXPECT_EQ(at_places(row(80)), "at (0, 0, 0) mm, (1, 0, 0) mm, (2, 0, 0) mm and 77 other places");
}

}  // namespace
}  // namespace angio::centerline

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "centerline/centerline.hpp"
#include "centerline/detail/contacts.hpp"
#include "centerline/detail/reference.hpp"
#include "core/statistics.hpp"
#include "testing/centerline/tree_lines.hpp"
#include "tests/centerline/straight_lines.hpp"

// Trees in which blood does not run from where the lines begin.
namespace angio::centerline {
namespace {

using benchmarks::Draw;
using benchmarks::Lines;
using benchmarks::TrueTree;

constexpr double kScatter = 0.05;  // of the radii at forks, with which trees are drawn

TrueTree healthy_tree(unsigned seed, bool with_two_inlets) {
  Draw draw{std::mt19937(seed)};
  TrueTree tree = grow_tree(draw, {});
  if (with_two_inlets) join(tree, grow_tree(draw, {}));
  for (benchmarks::TrueBranch& branch : tree.branches)
    branch.radius = branch.ectatic = branch.healthy;
  return tree;
}

int count_listed(const TrueTree& tree, unsigned seed) {
  const auto lesions = find_lesions(make_lines(tree, seed).tree, {});
  return int(std::count_if(lesions.begin(), lesions.end(),
                           [](const Lesion& lesion) { return lesion.is_stenosis; }));
}

/// How far the reference is from the healthy diameter, the median over all points [ln].
double reference_error(const TrueTree& tree, unsigned seed) {
  const Lines lines = make_lines(tree, seed);
  const TreeReference reference = find_reference(lines.tree, 0.0);
  std::vector<double> errors;
  for (std::size_t p = 0; p < lines.places.size(); ++p)
    for (std::size_t i = 0; i < lines.places[p].size(); ++i) {
      if (reference.paths[p].measured[i] <= 0.0) continue;
      const benchmarks::Place at = lines.places[p][i];
      const double healthy =
          2.0 * tree.branches[std::size_t(at.branch)].healthy[std::size_t(at.sample)];
      errors.push_back(std::abs(std::log(reference.paths[p].diameter[i] / healthy)));
    }
  return median(std::move(errors));
}

TEST(SeveralInlets, AHealthyTreeIsHealthyFromWhicheverEndItIsEntered) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const TrueTree tree = healthy_tree(seed, false);
    for (const double radius : {1e-9, 2.0, 1e9}) {
      const TrueTree turned = entered_at(tree, find_end(tree, radius));
      EXPECT_EQ(count_listed(turned, seed), 0) << seed << ", " << radius;
      EXPECT_LT(reference_error(turned, seed), kScatter) << seed << ", " << radius;
    }
  }
}

TEST(SeveralInlets, TwoHealthyTreesThatAreJoinedAreHealthy) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const TrueTree tree = healthy_tree(seed, true);
    EXPECT_EQ(count_listed(tree, seed), 0) << seed;
    EXPECT_LT(reference_error(tree, seed), kScatter) << seed;
  }
}

constexpr double kTight = 150.0;
constexpr int kMany = 40;

/// A line of 160 mm, and side branches of 2 mm that come back to it or go away.
CenterlineTree with_side_branches(int count, const std::function<double(double)>& diameter,
                                  bool come_back) {
  CenterlineTree tree;
  const CenterlinePath trunk = test::line_of(diameter, 160.0, 0);
  tree.paths.push_back(trunk);
  for (int k = 0; k < count; ++k) {
    const double start = 8.0 + 100.0 * k / count;
    CenterlinePath path;
    path.id = k + 1;
    for (std::size_t i = 0; trunk.points[i].z <= start; ++i) {
      path.points.push_back(trunk.points[i]);
      path.inscribed_radius.push_back(trunk.inscribed_radius[i]);
    }
    const double most = come_back ? units::kPi : 0.5 * units::kPi;
    for (double angle = 0.03; angle < most; angle += 0.03) {  // half a circle of 20 mm across
      path.points.push_back({10.0 * std::sin(angle) * std::cos(k),
                             10.0 * std::sin(angle) * std::sin(k),
                             start + 10.0 * (1.0 - std::cos(angle))});
      path.inscribed_radius.push_back(1.0);
    }
    tree.paths.push_back(path);
  }
  std::vector<std::vector<char>> is_tube;
  for (const CenterlinePath& path : tree.paths) is_tube.emplace_back(path.points.size(), 1);
  tree = test::tree_of(tree.paths);
  assign_tracts(tree, is_tube);
  return tree;
}

/// The same, of a line of 4 mm that is narrowed near its end.
CenterlineTree with_side_branches(int count, double depth, bool come_back) {
  const auto diameter = [=](double s) { return 4.0 * test::narrowed(s, kTight, 6.0, depth); };
  return with_side_branches(count, diameter, come_back);
}

TEST(SeveralInlets, LinesThatEndInAnotherVesselAreCounted) {
  EXPECT_EQ(count_cut_ends(with_side_branches(5, 0.0, true)), 5);
  EXPECT_EQ(count_cut_ends(with_side_branches(5, 0.0, false)), 0);
}

TEST(SeveralInlets, WhereVesselsTouchALesionNeedsMoreEvidence) {
  const auto listed = [](double depth, bool come_back) {
    return find_lesions(with_side_branches(kMany, depth, come_back), {});
  };
  double faint = 0.30;  // the least that is listed in a clean tree
  while (faint < 0.95 && !listed(faint, false).front().is_stenosis) faint += 0.01;
  const auto lesions = listed(faint, true);
  ASSERT_EQ(lesions.size(), 2U);
  EXPECT_FALSE(lesions[0].is_stenosis);
  EXPECT_EQ(lesions[1].doubt, Doubt::crowded);
  EXPECT_NEAR(lesions[1].abscissa_mm, kTight, 0.5);
  EXPECT_TRUE(
      find_lesions(with_side_branches(kMany, faint, true), {.centerline = 0}).front().is_stenosis);
  EXPECT_TRUE(listed(0.9, true).front().is_stenosis);
}

TEST(FaintEvidence, IsToldInATreeAndListedForALineThatIsNamedAndInOneVessel) {
  const auto is_faint = [](const Lesion& lesion) { return lesion.doubt == Doubt::faint; };
  // So long that the vessel may be thin by itself.
  const auto with_long_stenosis = [](int branches, double depth) {
    return with_side_branches(
        branches, [=](double s) { return 4.0 * test::narrowed(s, 110.0, 40.0, depth); }, false);
  };
  int faint = 0;
  for (double depth = 0.30; depth < 0.95; depth += 0.01) {
    const CenterlineTree tree = with_long_stenosis(5, depth);  // 11 branches
    const std::vector<Lesion> lesions = find_lesions(tree, {});
    const bool is_told = std::any_of(lesions.begin(), lesions.end(), is_faint);
    if (!is_told) continue;
    ++faint;
    EXPECT_TRUE(find_lesions(tree, {.centerline = 0}).front().is_stenosis) << depth;
    const std::vector<Lesion> alone = find_lesions(with_long_stenosis(0, depth), {});
    EXPECT_TRUE(std::none_of(alone.begin(), alone.end(), is_faint)) << depth;
  }
  EXPECT_GT(faint, 0);
}

TEST(FaintEvidence, HalfOfTheWidthIsNotMissingWithoutAWord) {
  // Of a line of 160 mm so much is thin, or so near its end, that nothing speaks for a stenosis.
  for (const auto& [place, length] : {std::pair{110.0, 50.0}, {120.0, 50.0}, {120.0, 60.0}}) {
    const auto diameter = [at = place, over = length](double s) {
      return 4.0 * test::narrowed(s, at, over, 0.9);
    };
    const std::vector<Lesion> lesions = find_lesions(with_side_branches(5, diameter, false), {});
    EXPECT_FALSE(lesions.front().is_stenosis);
    const auto told = std::find_if(lesions.begin(), lesions.end(), [](const Lesion& lesion) {
      return lesion.doubt == Doubt::faint && lesion.diameter_stenosis_percent >= 50.0;
    });
    ASSERT_NE(told, lesions.end()) << place << ", " << length;
    EXPECT_LT(told->evidence, 0.2);
    EXPECT_NEAR(told->abscissa_mm, place, 0.25 * length);
  }
}

TEST(DoubtfulStenosis, OfAVesselAsWideAsAHeartIsNotListedWhereVesselsTouch) {
  const auto scaled = [](double factor, bool come_back) {
    constexpr int kFew = 10;  // 21 branches: no large tree
    CenterlineTree tree = with_side_branches(kFew, 0.8, come_back);
    for (CenterlinePath& path : tree.paths)
      for (double& radius : path.inscribed_radius) radius *= factor;
    for (CenterlinePath& path : tree.paths)
      for (Vec3& point : path.points) point = factor * point;
    std::vector<std::vector<char>> is_tube;
    for (const CenterlinePath& path : tree.paths) is_tube.emplace_back(path.points.size(), 1);
    tree = test::tree_of(tree.paths);
    assign_tracts(tree, is_tube);
    return tree;
  };
  EXPECT_TRUE(find_lesions(scaled(5.0, true), {}).front().is_stenosis);   // 20 mm wide
  EXPECT_FALSE(find_lesions(scaled(8.0, true), {}).front().is_stenosis);  // 32 mm wide
  EXPECT_TRUE(find_lesions(scaled(8.0, false), {}).front().is_stenosis);  // and nothing touches
  EXPECT_TRUE(find_lesions(scaled(8.0, true), {.centerline = 0}).front().is_stenosis);
}

/// Whether a stenosis of an 8 mm vessel is listed, in a tree where vessels touch.
/// @param chambers  diameter of what lies before the vessel [mm]
bool lists_behind(const std::function<double(double)>& chambers, int line) {
  const auto diameter = [&](double s) {
    const double taper = std::clamp((105.0 - s) / 15.0, 0.0, 1.0);
    return (8.0 + (chambers(s) - 8.0) * taper) * test::narrowed(s, kTight, 6.0, 0.85);
  };
  const auto lesions = find_lesions(with_side_branches(4, diameter, true), {.centerline = line});
  return std::any_of(lesions.begin(), lesions.end(), [](const Lesion& lesion) {
    return lesion.is_stenosis && std::abs(lesion.abscissa_mm - kTight) < 3.0;
  });
}

TEST(DoubtfulStenosis, BeyondAChamberIsNotListedWhereVesselsTouch) {
  const auto with_valve = [](double front, double behind) {
    return
        [=](double s) { return (s < 55.0 ? front : behind) * test::narrowed(s, 55.0, 12.0, 0.7); };
  };
  EXPECT_TRUE(lists_behind([](double) { return 30.0; }, -1));
  EXPECT_FALSE(lists_behind(with_valve(30.0, 30.0), -1));
  EXPECT_TRUE(lists_behind(with_valve(30.0, 30.0), 0));  // asked for by name
  EXPECT_FALSE(lists_behind(with_valve(30.0, 24.0), -1));
  EXPECT_TRUE(lists_behind(with_valve(18.0, 18.0), -1));  // no wider than what is treated
  // A long way of half the width between two chambers is no stenosis, but leads out of the vessel.
  const auto long_neck = [](double s) {
    return 12.0 + 18.0 * std::clamp(std::abs(s - 55.0) / 8.0 - 3.0, 0.0, 1.0);
  };
  EXPECT_FALSE(lists_behind(long_neck, -1));
}

CenterlineTree tube_with(const std::function<double(double)>& diameter) {
  CenterlineTree tree = test::tree_of({test::line_of(diameter, 100.0, 0)});
  assign_tracts(tree, {std::vector<char>(tree.paths[0].points.size(), 1)});
  return tree;
}

TEST(DoubtfulStenosis, ThatAScansLineBeginsOrEndsInIsNotListed) {
  const auto listed = [](double at, const LesionOptions& options) {
    const CenterlineTree tree =
        tube_with([=](double s) { return 4.0 * test::narrowed(s, at, 3.0, 0.8); });
    return find_lesions(tree, options).front().is_stenosis;
  };
  const LesionOptions scan{.voxel_mm = 0.3}, surface{}, named{.centerline = 0, .voxel_mm = 0.3};
  EXPECT_FALSE(listed(2.0, scan));
  EXPECT_TRUE(listed(2.0, surface));
  EXPECT_TRUE(listed(2.0, named));
  EXPECT_TRUE(listed(20.0, scan));
  EXPECT_FALSE(listed(98.0, scan));
  EXPECT_TRUE(listed(98.0, surface));
  EXPECT_TRUE(listed(98.0, named));
  EXPECT_TRUE(listed(90.0, scan));
}

TEST(DoubtfulStenosis, ThreeInARowAreListedButNotTheBeadsOfAString) {
  const auto with_throats = [](int count) {
    return tube_with([=](double s) {
      double diameter = 4.0;
      for (int k = 0; k < count; ++k)
        diameter *= test::narrowed(s, 50.0 + 9.0 * (k - 0.5 * (count - 1)), 3.0, 0.5);
      return diameter;
    });
  };
  const auto count_listed = [&](int throats, const LesionOptions& options) {
    const std::vector<Lesion> lesions = find_lesions(with_throats(throats), options);
    return std::count_if(lesions.begin(), lesions.end(),
                         [](const Lesion& lesion) { return lesion.is_stenosis; });
  };
  EXPECT_EQ(count_listed(2, {}), 2);
  EXPECT_EQ(count_listed(3, {}), 3);
  EXPECT_EQ(count_listed(6, {}), 0);
  EXPECT_EQ(find_lesions(with_throats(6), {})[1].doubt, Doubt::bead);
  EXPECT_EQ(count_listed(6, {.centerline = 0}), 6);  // asked for by name
}

TEST(TrialPlace, IsNotWhereTheLumenIsNoTubeUnlessItIsNoneAnywhere) {
  const auto place = [](double first_flat, double last_flat) {
    CenterlineTree tree = tube_with([](double s) {
      return 4.0 * test::narrowed(s, 40.0, 3.0, 0.2) * test::narrowed(s, 65.0, 3.0, 0.12);
    });
    CenterlinePath& path = tree.paths[0];
    for (std::size_t i = 0; i < path.points.size(); ++i)
      if (path.abscissa[i] >= first_flat && path.abscissa[i] <= last_flat)
        path.equivalent_radius[i] = 1.5 * path.inscribed_radius[i];
    const Lesion lesion = find_lesions(tree, {}).front();
    EXPECT_FALSE(lesion.is_stenosis);
    return lesion.abscissa_mm;
  };
  EXPECT_NEAR(place(-2.0, -1.0), 40.0, 1.5);
  EXPECT_NEAR(place(34.0, 46.0), 65.0, 1.5);  // beside a sac
  EXPECT_NEAR(place(0.0, 100.0), 40.0, 1.5);  // an oval vessel
}

TEST(DoubtfulStenosis, TheErrorsOfAThreadOfALumenAreNoBeads) {
  const CenterlineTree tree = tube_with([](double s) {
    const double error = 0.03 * ((int(s / 2.0) % 2) != 0 ? 1.0 : -1.0);  // of the healthy width
    return 4.0 * (std::max(0.06, test::narrowed(s, 50.0, 30.0, 0.99)) + error);
  });
  const Lesion lesion = find_lesions(tree, {}).front();
  EXPECT_EQ(lesion.doubt, Doubt::none);
  EXPECT_TRUE(lesion.is_stenosis);
  EXPECT_GT(lesion.diameter_stenosis_percent, 85.0);
}

}  // namespace
}  // namespace angio::centerline

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include "centerline/centerline.hpp"
#include "centerline/detail/doubt.hpp"
#include "tests/centerline/straight_lines.hpp"

// Laws of the search for lesions, on lines without an extraction.
namespace angio::centerline {
namespace {

using test::line_of;
using test::narrowed;
using test::tree_of;

/// A trunk of 4 mm that forks into 3.2 and 2.9 mm after 30 mm (4^p = 3.2^p + 2.9^p at p = 2.7),
/// times a narrowing of each; the fork hides 4 mm of each side.
CenterlineTree forked(const std::function<double(double)>& of_trunk,
                      const std::function<double(double)>& of_first) {
  const auto daughter = [&](double width, const std::function<double(double)>& narrowing,
                            const Vec3& way, double length, int id) {
    CenterlinePath path = line_of([&](double s) { return 4.0 * of_trunk(s); }, 30.0, id);
    const int parting = int(path.points.size());
    const Vec3 start = path.points.back();
    for (double s = 0.2; s <= length; s += 0.125 * width * narrowing(s)) {
      path.points.push_back(start + s * way);
      path.inscribed_radius.push_back(0.5 * width * narrowing(s));
    }
    int first = parting, last = parting;
    while (path.points[std::size_t(first)].z > 26.0) --first;
    while (distance(path.points[std::size_t(last)], start) < 4.0) ++last;
    path.tracts = {{0, first, 0, 0, false},
                   {first, last, 1, 1, true},
                   {last, int(path.points.size()) - 1, 2 + id, 2, false}};
    return path;
  };
  return tree_of({daughter(3.2, of_first, normalized(Vec3{0.5, 0, 1}), 32.0, 0),
                  daughter(
                      2.9, [](double) { return 1.0; }, normalized(Vec3{-0.5, 0, 1}), 28.0, 1)});
}
double whole(double) { return 1.0; }

TEST(LesionLaws, ASizeDoesNotMatter) {
  const auto lesion = [](double scale) {
    LesionOptions options;
    options.min_reference_mm = 0.0;
    const auto diameter = [=](double s) {
      return 3.0 * scale * narrowed(s, 18.0 * scale, 5.0 * scale, 0.6);
    };
    return find_lesions(tree_of({line_of(diameter, 40.0 * scale)}), options).at(0);
  };
  const Lesion one = lesion(1.0);
  for (const double scale : {0.2, 7.0}) {
    const Lesion other = lesion(scale);
    EXPECT_NEAR(other.diameter_stenosis_percent, one.diameter_stenosis_percent, 1e-2);
    EXPECT_NEAR(other.length_mm, scale * one.length_mm, 1e-2 * scale);
    EXPECT_NEAR(other.evidence, one.evidence, 1e-2);
  }
}

TEST(LesionLaws, ATubeMayBeReadFromEitherEnd) {
  const auto diameter = [](double s) { return 3.0 * narrowed(s, 14.0, 5.0, 0.6); };
  CenterlinePath path = line_of(diameter, 40.0);
  CenterlinePath back = path;
  std::reverse(back.points.begin(), back.points.end());
  std::reverse(back.inscribed_radius.begin(), back.inscribed_radius.end());
  const double length = path.points.back().z;
  const Lesion a = find_lesions(tree_of({path}), {}).at(0);
  const Lesion b = find_lesions(tree_of({back}), {}).at(0);
  EXPECT_NEAR(a.diameter_stenosis_percent, b.diameter_stenosis_percent, 0.5);
  EXPECT_NEAR(a.abscissa_mm, length - b.abscissa_mm, 0.1);
}

TEST(LesionLaws, SeverityIsReadAsItIs) {
  double before = 0.0;
  for (const double depth : {0.35, 0.5, 0.65, 0.8, 0.9, 0.95}) {
    const auto diameter = [=](double s) { return 4.0 * narrowed(s, 25.0, 6.0, depth); };
    const auto lesions = find_lesions(tree_of({line_of(diameter, 50.0)}), {});
    ASSERT_EQ(lesions.size(), 1U);
    ASSERT_TRUE(lesions[0].is_stenosis) << depth;
    EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 100.0 * depth, 1.5);
    EXPECT_GT(lesions[0].diameter_stenosis_percent, before);
    EXPECT_GT(lesions[0].mld_mm, 0.0);
    before = lesions[0].diameter_stenosis_percent;
  }
}

double tapered(double s) { return 4.0 * (1.0 - 0.006 * s); }

/// A lesion of two throats in a vessel that tapers, 20 mm apart: narrowed by a depth and by 0.05
/// less; of 0.5, 1.64 mm and 1.54 mm are left.
CenterlineTree two_throats_in_a_taper(double depth) {
  return tree_of({line_of(
      [depth](double s) {
        return tapered(s) *
               std::min({narrowed(s, 30.0, 6.0, depth), narrowed(s, 50.0, 6.0, depth - 0.05),
                         s > 30.0 && s < 50.0 ? 0.7 : 1.0});
      },
      80.0)});
}

TEST(LesionLaws, PlaceReferenceAndPercentAreThoseOfTheMld) {
  const auto lesions = find_lesions(two_throats_in_a_taper(0.45), {});
  ASSERT_EQ(lesions.size(), 1U);
  const Lesion& lesion = lesions[0];
  EXPECT_NEAR(lesion.abscissa_mm, 50.0, 0.5);
  EXPECT_NEAR(lesion.mld_mm, 0.6 * tapered(50.0), 0.03);
  EXPECT_NEAR(lesion.reference_diameter_mm, tapered(50.0), 0.2);  // at the first, 0.48 more
  EXPECT_NEAR(lesion.reference_interpolated_mm, tapered(50.0), 0.05);
  EXPECT_NEAR(lesion.diameter_stenosis_percent, 40.0, 4.0);
}

TEST(LesionLaws, WhereHalfIsMissingThePlaceIsOneWhereItIs) {
  const auto lesions = find_lesions(two_throats_in_a_taper(0.53), {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_NEAR(lesions[0].abscissa_mm, 30.0, 0.5);
  EXPECT_GT(lesions[0].diameter_stenosis_percent, 50.0);
}

TEST(LesionLaws, WhatIsListedForAThroatIsOneWhereItIsSaidToBe) {
  const auto lesions = find_lesions(two_throats_in_a_taper(0.45), {.min_stenosis_percent = 42.5});
  ASSERT_EQ(lesions.size(), 1U);
  const Lesion& lesion = lesions[0];
  EXPECT_TRUE(lesion.is_stenosis);
  EXPECT_NEAR(lesion.abscissa_mm, 30.0, 0.5);
  EXPECT_NEAR(lesion.mld_mm, 0.55 * tapered(30.0), 0.03);
  EXPECT_NEAR(lesion.diameter_stenosis_percent, 45.0, 5.0);
}

TEST(LesionLaws, AVesselIsNoReferenceForItsOwnNarrowing) {
  // 19.7 mm, narrowed to 3.56 mm over 6 diameters: 82 %.
  const auto diameter = [](double s) { return 19.7 * narrowed(s, 100.0, 60.0, 1.0 - 3.56 / 19.7); };
  const Lesion lesion = find_lesions(tree_of({line_of(diameter, 200.0)}), {}).at(0);
  EXPECT_TRUE(lesion.is_stenosis);
  EXPECT_NEAR(lesion.reference_diameter_mm, 19.7, 1.0);
  EXPECT_NEAR(lesion.diameter_stenosis_percent, 82.0, 1.5);
}

/// A line of 3 mm that turns by 153 degrees round a place narrowed by 60 %, as in a siphon or an
/// aortic arch; and one of another width that goes straight on from a millimetre and a half into
/// the bend, 2.5 mm before the place.
CenterlineTree narrow_in_bend(double half, std::optional<double> passing) {
  constexpr double kBegin = 16.0, kRadius = 3.0, kAngle = 8.0 / kRadius, kParting = 17.5;
  CenterlinePath path =
      line_of([=](double s) { return 3.0 * narrowed(s, 20.0, half, 0.6); }, 40.0, 0);
  CenterlinePath straight;
  straight.id = 1;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    Vec3& p = path.points[i];
    const double s = p.z, angle = std::clamp((s - kBegin) / kRadius, 0.0, kAngle);
    const double before = std::min(s, kBegin), after = std::max(0.0, s - kBegin - 8.0);
    p = Vec3{kRadius * (1.0 - std::cos(angle)) + after * std::sin(angle), 0.0,
             before + kRadius * std::sin(angle) + after * std::cos(angle)};
    if (s > kParting) continue;
    straight.points.push_back(p);
    straight.inscribed_radius.push_back(path.inscribed_radius[i]);
  }
  if (!passing) return tree_of({path});
  const double angle = (kParting - kBegin) / kRadius;
  const Vec3 start = straight.points.back(), way{std::sin(angle), 0.0, std::cos(angle)};
  for (double s = 0.2; s < 20.0; s += 0.125 * *passing) {
    straight.points.push_back(start + s * way);
    straight.inscribed_radius.push_back(0.5 * *passing);
  }
  return tree_of({path, straight});
}

Lesion on_the_bent_line(const std::vector<Lesion>& lesions) {
  const auto found = std::find_if(lesions.begin(), lesions.end(), [](const Lesion& lesion) {
    return lesion.path_id == 0 && lesion.length_mm > 0.0;
  });
  if (found != lesions.end()) return *found;
  ADD_FAILURE() << "nothing is said of the bent line";
  return {};
}

TEST(LesionLaws, AShortNeckInABendIsAStenosisUnlessAVesselPassesItBy) {
  for (const double half : {4.0, 2.0, 1.2})
    for (const std::optional<double> passing : {std::optional<double>{}, {1.2}}) {
      const auto lesions = find_lesions(narrow_in_bend(half, passing), {});
      const Lesion stenosis = on_the_bent_line(lesions);
      EXPECT_TRUE(stenosis.is_stenosis) << half;
      EXPECT_NEAR(stenosis.diameter_stenosis_percent, 60.0, 3.0);
    }
  // Longer than from the one vessel's axis to the other's, it is no bridge between them.
  const auto as_wide = find_lesions(narrow_in_bend(4.5, 3.0), {});
  EXPECT_GT(on_the_bent_line(as_wide).length_mm, 1.25 * 3.0);
  EXPECT_NE(on_the_bent_line(as_wide).doubt, Doubt::bridge);
  for (const double passing : {3.0, 3.6}) {  // it may be the wider one, which the vessel goes on in
    const CenterlineTree touching = narrow_in_bend(2.0, passing);
    const Lesion bridge = on_the_bent_line(find_lesions(touching, {}));
    EXPECT_FALSE(bridge.is_stenosis) << passing;
    EXPECT_EQ(bridge.doubt, Doubt::bridge) << passing;
    // Who names the line has looked.
    EXPECT_TRUE(on_the_bent_line(find_lesions(touching, {.centerline = 0})).is_stenosis) << passing;
  }
}

TEST(LesionLaws, AtTheInletALesionIsFound) {
  const auto diameter = [](double s) { return 4.0 * narrowed(s, 1.0, 7.0, 0.7); };
  const Lesion lesion = find_lesions(tree_of({line_of(diameter, 50.0)}), {}).at(0);
  EXPECT_TRUE(lesion.is_stenosis);
  EXPECT_NEAR(lesion.diameter_stenosis_percent, 70.0, 3.0);
  EXPECT_EQ(lesion.reference_proximal_mm, 0.0);
  EXPECT_EQ(lesion.reference_interpolated_mm, 0.0);
  EXPECT_NEAR(lesion.reference_average_mm, lesion.reference_distal_mm, 1e-12);
}

TEST(LesionLaws, WhereTheTreeBeginsAFaintNarrowingIsInDoubtAsWhereItEnds) {
  // Nearly as long narrow as wide: which of the two is healthy is not known.
  const auto begins_thin = [](double s) {
    return s < 16.0 ? 2.0 : std::min(4.0, 2.0 + (s - 16.0));
  };
  const Lesion lesion = find_lesions(tree_of({line_of(begins_thin, 36.0)}), {}).at(1);
  EXPECT_NEAR(lesion.diameter_stenosis_percent, 50.0, 4.0);
  EXPECT_GT(lesion.evidence, 0.2);
  EXPECT_LT(lesion.evidence, 1.0);
  EXPECT_EQ(lesion.doubt, Doubt::faint);
}

TEST(Doubt, OfAnEndWhoseHealthyWidthIsKnownFromBeyondAnAneurysmAlone) {
  // 4.2 mm, then 3 mm to where the surface is cut open; with or without an aneurysm in between.
  const auto find = [](double bulge_mm) {
    const auto diameter = [bulge_mm](double s) {
      const double x = (s - 16.0) / 4.0;
      const double bulge =
          std::abs(x) < 1.0 ? 0.5 * bulge_mm * (1.0 + std::cos(units::kPi * x)) : 0.0;
      return bulge + (s < 16.0 ? 4.2 : std::max(1.8, 3.0 - 0.1 * std::max(0.0, s - 20.0)));
    };
    for (const Lesion& lesion : find_lesions(tree_of({line_of(diameter, 28.0)}), {}))
      if (lesion.is_stenosis || lesion.is_left_out()) return lesion;
    return Lesion{};
  };
  const Lesion beyond = find(4.8);
  EXPECT_NEAR(beyond.diameter_stenosis_percent, 47.0, 4.0);
  EXPECT_GT(beyond.evidence, 1.0);
  EXPECT_LT(beyond.evidence, 2.0);
  EXPECT_EQ(beyond.doubt, Doubt::beyond_aneurysm);
  EXPECT_NE(find(0.0).doubt, Doubt::beyond_aneurysm);
}

TEST(Doubt, OfANarrowingBetweenLumensThatAreNotTheSameBlood) {
  const auto diameter = [](double s) { return 4.0 * narrowed(s, 30.0, 6.0, 0.6); };
  const CenterlineTree tree = tree_of({line_of(diameter, 60.0)});
  const auto doubt_where = [&](const std::function<double(double)>& behind) {
    const auto intensity = [&](const Vec3& at) {
      if (std::hypot(at.x, at.y) > 0.5 * diameter(at.z)) return 50.0;  // tissue
      return at.z < 30.0 ? 450.0 : behind(at.z);
    };
    for (const Lesion& lesion : find_lesions(tree, {.voxel_mm = 0.5, .intensity = intensity}))
      if (lesion.is_stenosis || lesion.is_left_out()) return lesion.doubt;
    return Doubt::faint;
  };
  EXPECT_EQ(doubt_where([](double) { return 450.0; }), Doubt::none);
  EXPECT_EQ(doubt_where([](double) { return 410.0; }), Doubt::none);
  EXPECT_EQ(doubt_where([](double) { return 320.0; }), Doubt::none);  // a severe one's late blood
  EXPECT_EQ(doubt_where([](double) { return 580.0; }), Doubt::other_blood);
  EXPECT_EQ(doubt_where([](double) { return 200.0; }), Doubt::other_blood);
  EXPECT_EQ(doubt_where([](double z) { return std::sin(2.0 * z) > 0.0 ? 540.0 : 360.0; }),
            Doubt::other_blood);  // as bright, but not even
}

TEST(LesionLaws, AClosedTipIsNone) {
  const auto tip = [](double s) { return std::max(4.0 * std::min(1.0, (50.0 - s) / 12.0), 1e-3); };
  EXPECT_FALSE(find_lesions(tree_of({line_of(tip, 50.0)}), {}).at(0).is_stenosis);
  const auto begun = [](double s) { return std::max(4.0 * std::min(1.0, s / 12.0), 1e-3); };
  EXPECT_FALSE(find_lesions(tree_of({line_of(begun, 50.0)}), {}).at(0).is_stenosis);
}

TEST(LesionLaws, InARaggedEndThatIsClosedANarrowingIsInDoubt) {
  // A blunt tip, a neck of 1.2 mm, then the vessel of 4.4 mm: a dent in the end of a segmentation.
  const auto dented = [](double s) {
    if (s < 1.3) return 0.1 + 1.4 * s;
    const double neck = std::max(1.92 - 0.32 * (s - 1.3), 1.3 - 0.04 * (s - 3.2));
    return std::lerp(neck, 4.4, std::clamp((s - 4.2) / 2.0, 0.0, 1.0));
  };
  const auto doubt_of = [](const std::function<double(double)>& diameter) {
    CenterlinePath line = line_of(diameter, 60.0);
    for (std::size_t i = 0; i < line.points.size(); ++i) {  // in a tip the tube goes on as it was
      const double to_tip = std::min(line.points[i].z, 60.0 - line.points[i].z);
      line.tube_radius.push_back(to_tip < 1.3 ? std::max(line.inscribed_radius[i], 0.96)
                                              : line.inscribed_radius[i]);
    }
    const CenterlineTree tree = tree_of({line});
    const auto lesions = find_lesions(tree, {});
    const auto narrow = std::find_if(lesions.begin(), lesions.end(), [](const Lesion& lesion) {
      return lesion.diameter_stenosis_percent > 50.0;
    });
    return narrow == lesions.end() ? std::optional<Doubt>() : narrow->doubt;
  };
  EXPECT_EQ(doubt_of(dented), Doubt::at_beginning);
  EXPECT_EQ(doubt_of([&](double s) { return dented(60.0 - std::min(s, 60.0)); }), Doubt::at_end);
  // Where the line begins in an opening as wide as the neck, it may be the stenosis that it seems.
  EXPECT_EQ(doubt_of([&](double s) { return std::max(dented(s), 1.2); }), Doubt::none);
}

/// Lesions of a vessel of 4 mm that is narrowed, whose wall has triangles of an edge.
std::vector<Lesion> lesions_of_coarse_wall(double narrowing, double edge_mm, double voxel_mm) {
  const auto diameter = [=](double s) { return 4.0 * narrowed(s, 25.0, 7.0, narrowing); };
  LesionOptions options;
  options.edge_mm = [=](const Vec3&, double) { return edge_mm; };
  options.voxel_mm = voxel_mm;
  return find_lesions(tree_of({line_of(diameter, 50.0)}), options);
}

TEST(LesionLaws, AStenosisIsListedIfAPolygonOfItsEdgesStillShowsOne) {
  // Around a ball of diameter d the corners of a regular polygon of n edges lie on a circle of
  // d / cos(pi / n); its edges are d tan(pi / n), and d^2 + edge^2 is that circle's square.
  for (const int n : {3, 4, 5, 6, 8}) {
    const double d = 2.0, edge = d * std::tan(std::numbers::pi / n);
    EXPECT_NEAR(std::hypot(d, edge), d / std::cos(std::numbers::pi / n), 1e-12) << n;
  }
  // 4 mm narrowed to 1.2: with edges e up to hypot(1.2, e), 30 % and more below 2.8: e < 2.53.
  for (const double edge : {0.3, 1.4, 2.4}) {
    const auto lesions = lesions_of_coarse_wall(0.7, edge, 0.0);
    EXPECT_TRUE(lesions[0].is_stenosis) << edge;
    EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 70.0, 2.0) << edge;
  }
  for (const double edge : {2.7, 5.0}) {
    const auto lesions = lesions_of_coarse_wall(0.7, edge, 0.0);
    ASSERT_EQ(lesions.size(), 2U) << edge;
    EXPECT_FALSE(lesions[0].is_stenosis) << edge;
    EXPECT_TRUE(lesions[1].is_too_thin) << edge;
  }
  // 2.6 mm of 4 are 35 %, with edges of 1.5 perhaps 25 %; with nine vertices around it is measured.
  EXPECT_FALSE(lesions_of_coarse_wall(0.35, 1.5, 0.0)[0].is_stenosis);
  EXPECT_TRUE(lesions_of_coarse_wall(0.35, 1.3, 0.0)[0].is_stenosis);
}

TEST(LesionLaws, CoarseTrianglesOfVoxelsShowWhatLabelsDo) {
  // 4 mm are eight, five and two and a half voxels; of edges of 1.5 mm there are too few around.
  EXPECT_TRUE(lesions_of_coarse_wall(0.7, 1.5, 0.5)[0].is_stenosis);
  EXPECT_FALSE(lesions_of_coarse_wall(0.7, 1.5, 0.8)[0].is_stenosis);
  EXPECT_TRUE(lesions_of_coarse_wall(0.7, 0.5, 0.8)[0].is_stenosis);
  EXPECT_FALSE(lesions_of_coarse_wall(0.7, 0.5, 1.6)[0].is_stenosis);
}

TEST(LesionLaws, AThreadAtTheEndIsNotWhatTheVesselIsHealthyAs) {
  // So ragged that no width is its own; the thread behind it is even, and in its own diameters
  // long.
  const auto ragged = [](double s) {
    return 2.6 * std::exp(0.3 * (std::sin(0.55 * s) + std::sin(0.23 * s + 1.0)));
  };
  for (const double voxel : {0.0, 0.24, 0.4}) {
    LesionOptions options;
    options.voxel_mm = voxel;
    options.abscissa_mm = 100.0;
    const auto reference = [&](double thread_mm) {
      const auto diameter = [&](double s) { return s < 200.0 ? ragged(s) : 0.45; };
      return find_lesions(tree_of({line_of(diameter, 200.0 + thread_mm)}), options)
          .front()
          .reference_diameter_mm;
    };
    EXPECT_GT(reference(0.0), 1.5) << voxel;
    EXPECT_NEAR(reference(15.0), reference(0.0), 0.3 * reference(0.0)) << voxel;
  }
}

TEST(LesionLaws, BesideALumenThatIsNoTubeANarrowingIsToldApart) {
  // Behind the throat sections are as flat as a vein (2 to 1), or as an organ's rind (4 to 1).
  const auto diameter = [](double s) { return 4.0 * narrowed(s, 25.0, 7.0, 0.7); };
  for (const double flat : {2.0, 4.0}) {
    CenterlineTree tree = tree_of({line_of(diameter, 50.0)});
    CenterlinePath& path = tree.paths[0];
    for (std::size_t i = 0; i < path.points.size(); ++i)
      if (path.abscissa[i] > 27.0) {
        path.equivalent_radius[i] *= std::sqrt(flat);
        path.section_area[i] *= flat;
      }
    EXPECT_EQ(find_lesions(tree, {})[0].is_stenosis, flat < 2.5) << flat;
    LesionOptions there;
    there.centerline = 0;
    EXPECT_TRUE(find_lesions(tree, there)[0].is_stenosis) << flat;
  }
}

TEST(LesionLaws, ALongVesselIsHardlyWiderThanItsWidestPlace) {
  // By its daughters the trunk, 3.4 mm at its widest, is one of 4 mm.
  const auto trunk = [](double s) { return (s < 22.0 ? 0.8 : 0.85) * narrowed(s, 12.0, 8.0, 0.3); };
  const CenterlineTree tree = forked([&](double s) { return s < 30.0 ? trunk(s) : 1.0; }, whole);
  LesionOptions options;
  options.abscissa_mm = 12.0;
  EXPECT_LT(find_lesions(tree, options).at(0).reference_diameter_mm, 1.1 * 3.4 + 0.02);
}

TEST(LesionLaws, AHealthyForkIsNone) {
  EXPECT_FALSE(find_lesions(forked(whole, whole), {}).at(0).is_stenosis);
}

TEST(LesionLaws, BehindAForkALesionIsMeasuredByItsOwnBranch) {
  const auto ostium = [](double s) { return narrowed(s, 5.0, 5.0, 0.6); };
  const auto lesions = find_lesions(forked(whole, ostium), {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_TRUE(lesions[0].is_stenosis);
  EXPECT_NEAR(lesions[0].reference_diameter_mm, 3.2, 0.1);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 60.0, 1.0);
}

TEST(LesionLaws, ALesionMayRunIntoAFork) {
  const auto end = [](double s) { return s < 20.0 ? narrowed(s, 20.0, 6.0, 0.5) : 0.5; };
  const auto lesions = find_lesions(forked(end, whole), {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_TRUE(lesions[0].is_stenosis);
  EXPECT_NEAR(lesions[0].reference_diameter_mm, 4.0, 0.15);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 50.0, 2.0);
}

TEST(LesionLaws, NeitherTaperNorEctasiaNorAVesselThatEndsInAThinOneIsALesion) {
  const std::vector<std::function<double(double)>> healthy{
      [](double s) { return 4.0 - 0.04 * s; },
      [](double s) { return 4.0 * (2.0 - narrowed(s, 30.0, 10.0, 0.8)); },
      [](double s) { return 10.0 * (2.0 - narrowed(s, 30.0, 20.0, 1.0)); },
      [](double s) { return s < 30.0 ? 3.0 : 2.4; },
      [](double s) { return std::max(3.5, 25.0 - 1.2 * s); },
  };
  for (std::size_t k = 0; k < healthy.size(); ++k)
    EXPECT_FALSE(find_lesions(tree_of({line_of(healthy[k], 70.0)}), {}).at(0).is_stenosis) << k;
}

TEST(Doubt, OfAReferenceThatIsWiderThanTheVesselOnBothSides) {
  Lesion lesion;
  lesion.reference_tree_mm = 22.0;
  lesion.reference_proximal_mm = 11.0;
  EXPECT_FALSE(is_wider_than_beside(lesion)) << "of one side alone nothing is known";
  lesion.reference_distal_mm = 12.0;
  EXPECT_TRUE(is_wider_than_beside(lesion));
  lesion.reference_proximal_mm = 15.0;
  EXPECT_FALSE(is_wider_than_beside(lesion));
}

// What the tree makes of forks far away is no reference for a throat between two stretches of
// vessel that are both thinner; and what is less than a tenth is the taper's.
TEST(LesionReferences, AreNoWiderThanBothSides) {
  const auto between = [](double width, double beside = 0.0) {
    const CenterlineTree tree = tree_of({line_of(
        [=](double s) {
          return width * std::min({narrowed(s, 20.0, 4.0, 0.6), narrowed(s, 12.0, 3.0, beside),
                                   narrowed(s, 28.0, 3.0, beside)});
        },
        40.0)});
    const CenterlinePath& path = tree.paths.front();
    TreeReference reference = find_reference(tree, 0.0);
    ReferenceDiameter& wide = reference.paths.front();
    std::fill(wide.diameter.begin(), wide.diameter.end(), 4.0);
    const Vessel whole{0, 0, path.points.size() - 1};
    const Known known{path, reference, wide};
    const auto throat =
        std::size_t(std::min_element(path.inscribed_radius.begin(), path.inscribed_radius.end()) -
                    path.inscribed_radius.begin());
    return describe_dip(known, whole, grow_dip(known, whole, throat));
  };
  const Lesion thinner = between(3.4), as_wide = between(3.8);
  EXPECT_EQ(thinner.reference_rule, "sides");
  EXPECT_NEAR(thinner.reference_diameter_mm, 3.4, 0.02);
  EXPECT_EQ(thinner.reference_tree_mm, 4.0);
  EXPECT_NEAR(thinner.diameter_stenosis_percent, 60.0, 1.0);
  EXPECT_EQ(as_wide.reference_rule, "tree");
  EXPECT_EQ(as_wide.reference_diameter_mm, 4.0);
  // Lesions in front and behind are no vessel to be referred to.
  EXPECT_EQ(between(3.4, 0.59).reference_rule, "tree");
}

// A vessel of 4 mm is 3.4 mm wide on both sides of a throat: what is 30 % or more of 4 mm alone is
// none, and is not told either.
TEST(LesionReferences, ThatBothSidesRefuteMakeNoStenosis) {
  const auto narrowings = [](double throat) {
    const CenterlineTree tree = tree_of({line_of(
        [=](double s) {
          const double vessel = std::abs(s - 35.0) < 11.0 ? 3.4 : 4.0;
          return vessel * narrowed(s, 35.0, 4.0, 1.0 - throat / 3.4);
        },
        70.0)});
    std::vector<Lesion> found = find_lesions(tree, {});
    std::erase_if(found, [](const Lesion& lesion) {
      return !lesion.is_stenosis && lesion.doubt == Doubt::none;  // the trial place
    });
    return found;
  };
  const std::vector<Lesion> deep = narrowings(1.7);
  ASSERT_EQ(deep.size(), 1U);
  EXPECT_TRUE(deep[0].is_stenosis);
  EXPECT_EQ(deep[0].reference_rule, "sides");
  EXPECT_NEAR(deep[0].diameter_stenosis_percent, 50.0, 1.0);
  EXPECT_TRUE(narrowings(2.6).empty());
}

TEST(TightestPlace, BehindAWideRootIsReferredToTheVesselItself) {
  // A root of 8.5 mm that ends slowly, then a vessel of 5.5 mm that undulates.
  const auto diameter = [](double s) {
    const double root = 4.0 / (1.0 + std::exp((s - 18.0) / 15.0));
    return 5.5 + root + 0.3 * std::sin(0.4 * s);
  };
  const auto check = [](const Lesion& place) {
    EXPECT_FALSE(place.is_stenosis);
    EXPECT_EQ(place.path_id, 0);
    EXPECT_NEAR(place.reference_diameter_mm, 5.5, 0.4);
    EXPECT_LT(place.diameter_stenosis_percent, 12.0);
    EXPECT_EQ(place.reference_rule, "vessel");
    EXPECT_GT(place.reference_tree_mm, place.reference_diameter_mm);
  };
  const Lesion place = find_lesions(tree_of({line_of(diameter, 120.0)}), {}).at(0);
  check(place);
  // A narrowing that is left out, in another vessel, changes nothing.
  CenterlinePath thin =
      line_of([](double s) { return 2.0 * narrowed(s, 20.0, 5.0, 0.6); }, 40.0, 1);
  for (Vec3& p : thin.points) p.x += 60.0;
  LesionOptions options;
  options.voxel_mm = 0.8;
  const auto beside = find_lesions(tree_of({line_of(diameter, 120.0), thin}), options);
  EXPECT_EQ(beside.size(), 2U);
  EXPECT_TRUE(beside.back().is_too_thin);
  check(beside.front());
  // Nor does it change that the place is named.
  options = {};
  options.centerline = 0;
  options.abscissa_mm = place.abscissa_mm;
  const Lesion named = find_lesions(tree_of({line_of(diameter, 120.0)}), options).at(0);
  check(named);
  EXPECT_EQ(named.reference_diameter_mm, place.reference_diameter_mm);
}

TEST(LesionLaws, WhatABranchingHidesIsNotMeasured) {
  CenterlineTree tree = forked(whole, whole);
  for (CenterlinePath& path : tree.paths) {
    const CenterlineTract hidden = path.tracts[1];
    for (int i = hidden.first_point + 1; i < hidden.last_point; ++i)
      path.inscribed_radius[std::size_t(i)] = 0.2;
  }
  EXPECT_FALSE(find_lesions(tree, {}).at(0).is_stenosis);
}

TEST(LesionLaws, ASingleWrongRadiusIsNoThroat) {
  // The spheres beside it prove that the lumen is wide.
  CenterlinePath path = line_of([](double s) { return 3.0 * narrowed(s, 20.0, 5.0, 0.5); }, 40.0);
  for (std::size_t i = 1; i + 1 < path.points.size(); i += 17) path.inscribed_radius[i] = 0.01;
  const auto lesions = find_lesions(tree_of({path}), {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 50.0, 3.0);
}

TEST(TightestPlace, IsRatherInAVesselThatIsTreated) {
  // 2 mm at first, 1.3 mm behind a fork's step, where it undulates more.
  const auto diameter = [](double s) {
    return s < 30.0 ? 2.0 * (1.0 - 0.04 * (1.0 + std::sin(s)))
                    : 1.3 * (1.0 - 0.1 * (1.0 + std::sin(s)));
  };
  const Lesion place = find_lesions(tree_of({line_of(diameter, 60.0)}), {}).at(0);
  EXPECT_FALSE(place.is_stenosis);
  EXPECT_GT(place.reference_diameter_mm, 1.5);
  // Where all is thinner, in that.
  const auto thin = [](double s) { return 1.3 * (1.0 - 0.04 * (1.0 + std::sin(s))); };
  EXPECT_NEAR(find_lesions(tree_of({line_of(thin, 60.0)}), {}).at(0).reference_diameter_mm, 1.3,
              0.15);
}

TEST(TightestPlace, IsRatherNotInASharpBend) {
  // Straight but for a bend around (0, 0, 20); 10 % narrower there, and 6 % at 45 mm.
  const auto place = [](double radius_of_bend) {
    const auto diameter = [](double s) {
      return 4.0 * narrowed(s, 20.0, 4.0, 0.10) * narrowed(s, 45.0, 4.0, 0.06);
    };
    CenterlinePath path = line_of(diameter, 60.0);
    double angle = 0.0;
    Vec3 at{0, 0, 0};
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const double s = path.points[i].z;
      const double step = i + 1 < path.points.size() ? path.points[i + 1].z - s : 0.0;
      path.points[i] = at;
      if (std::abs(s - 20.0) < 4.0) angle += step / radius_of_bend;
      at += step * Vec3{std::sin(angle), 0, std::cos(angle)};
    }
    const Lesion lesion = find_lesions(tree_of({path}), {}).at(0);
    EXPECT_FALSE(lesion.is_stenosis);
    return lesion.abscissa_mm;
  };
  EXPECT_NEAR(place(50.0), 20.0, 2.0);
  EXPECT_NEAR(place(5.0), 45.0, 2.0);  // 92 degrees
}

/// Of 4 mm, and 70 % thinner over `length` in its middle.
CenterlineTree diffuse_vessel(double length, double whole = 66.0, double percent = 70.0) {
  const auto diameter = [=](double s) {
    const double in = 0.5 * length - std::abs(s - 0.5 * whole);  // [mm] behind the edge
    const double part = std::clamp(in / 3.0, 0.0, 1.0);
    return 4.0 * (1.0 - 0.01 * percent * part * part * (3.0 - 2.0 * part));
  };
  return tree_of({line_of(diameter, whole)});
}

TEST(DiffuseDisease, IsListedOrTold) {
  for (const double percent : {50.0, 70.0})
    for (double length = 15.0; length <= 50.0; length += 5.0) {
      const std::vector<Lesion> lesions = find_lesions(diffuse_vessel(length, 66.0, percent), {});
      const auto said = std::find_if(lesions.begin(), lesions.end(), [](const Lesion& lesion) {
        return lesion.is_stenosis || lesion.doubt == Doubt::diffuse || lesion.doubt == Doubt::faint;
      });
      ASSERT_NE(said, lesions.end()) << percent << " % over " << length << " mm";
      EXPECT_NEAR(said->diameter_stenosis_percent, percent, 2.0) << length;
      EXPECT_NEAR(said->reference_diameter_mm, 4.0, 0.1) << length;
      EXPECT_NE(said->is_stenosis, said->is_doubtful());
    }
}

TEST(DiffuseDisease, IsNotATaperOrAnAneurysm) {
  const auto none = [](const std::function<double(double)>& diameter) {
    for (const Lesion& lesion : find_lesions(tree_of({line_of(diameter, 60.0)}), {}))
      EXPECT_NE(lesion.doubt, Doubt::diffuse);
  };
  none([](double s) { return 4.0 * std::exp(-0.02 * s); });
  none([](double s) { return 4.0 * (2.0 - narrowed(s, 30.0, 12.0, 1.0)); });  // wide in the middle
  none([](double s) { return s < 30.0 ? 4.0 : 2.2; });                        // a step
}

}  // namespace
}  // namespace angio::centerline

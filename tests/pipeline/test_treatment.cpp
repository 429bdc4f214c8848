#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/units.hpp"
#include "pipeline/stages/treatment.hpp"

namespace angio::pipeline {
namespace {

Treatment treatment(double before, double peak, double after) {
  const auto at = [](double mld) {
    const centerline::Tightest t{mld, 0.25 * units::kPi * mld * mld, 0.0};
    return TreatedMeasures{t, t, std::nullopt};
  };
  return {at(before), at(peak), at(after)};
}

TEST(Treatment, GainAndRecoilAreOfTheSameSurface) {
  const Treatment t = treatment(1.0, 3.0, 2.4);
  const nlohmann::json json = treatment_json(t, std::nullopt, 3.0, 3.2);
  EXPECT_NEAR(json.at("result").at("acute_gain_mm").get<double>(), 1.4, 1e-12);
  EXPECT_NEAR(json.at("result").at("recoil_mm").get<double>(), 0.6, 1e-12);
  EXPECT_NEAR(json.at("result").at("recoil_percent").get<double>(), 20.0, 1e-12);
  EXPECT_NEAR(json.at("lesion").at("diameter_stenosis_percent").get<double>(), 200.0 / 3, 1e-12);
  EXPECT_NEAR(json.at("lesion").at("area_stenosis_percent").get<double>(), 800.0 / 9, 1e-12);
  EXPECT_NEAR(json.at("peak").at("diameter_stenosis_percent").get<double>(), 0.0, 1e-12);
  EXPECT_NEAR(json.at("peak").at("area_stenosis_percent").get<double>(), 0.0, 1e-12);
  EXPECT_NEAR(json.at("result").at("area_stenosis_percent").get<double>(), 36.0, 1e-12);
  EXPECT_NEAR(json.at("result").at("recoil_percent_of_balloon").get<double>(), 25.0, 1e-12);
  EXPECT_NEAR(json.at("result").at("recoil_percent_of_gain").get<double>(), 30.0, 1e-12);
  EXPECT_TRUE(json.at("result").at("lumen_eccentricity").is_null());
  EXPECT_TRUE(json.at("result").at("acute_gain_range_mm").is_null());
  // Widening = gain + recoil.
  EXPECT_NEAR(t.gain_mm() + t.recoil_mm(), 2.0, 1e-12);
}

/// A vessel that is 6 mm wide with a lesion around 25 mm and another dip at 70 mm; the balloon
/// holds 6.3 mm there, and `wide` from 40 to 60 mm.
std::optional<WideningBeside> widening_with(double wide) {
  centerline::LumenProfile before, peak;
  const auto add = [](centerline::LumenProfile& profile, double s, double diameter) {
    profile.abscissa.push_back(s);
    profile.inscribed_radius.push_back(0.5 * diameter);
    profile.section_area.push_back(0.25 * units::kPi * diameter * diameter);
  };
  for (double s = 0.0; s <= 80.0; s += 1.0) {
    const double lesion = std::abs(s - 25.0) < 4.0 ? 3.0 : 0.0, dip = s == 70.0 ? 2.0 : 0.0;
    add(before, s, 6.0 - lesion - dip);
    add(peak, s, s >= 40.0 && s <= 60.0 ? wide : 6.3);
  }
  return widening_beside(before, peak, {{20.0, 30.0}}, 6.0);
}

TEST(WideningBeside, IsTheMostThatHealthyVesselGivesWay) {
  ASSERT_TRUE(widening_with(9.0));
  EXPECT_NEAR(widening_with(9.0)->ratio, 1.5, 1e-12);
  EXPECT_NEAR(widening_with(9.0)->before_mm, 6.0, 1e-12);
  ASSERT_EQ(widening_warnings(widening_with(9.0), true).size(), 1U);
  EXPECT_NE(widening_warnings(widening_with(9.0), true)[0].find("beside the lesion"),
            std::string::npos);
  EXPECT_EQ(widening_warnings(widening_with(9.0), false)[0].find("lesion"), std::string::npos)
      << "there is none";
  EXPECT_NEAR(widening_with(6.3)->ratio, 1.05, 1e-12) << "neither the lesion nor the dip counts";
  EXPECT_TRUE(widening_warnings(widening_with(6.3), true).empty());
  // 1.204 times is told as 1.20, which is the limit.
  EXPECT_TRUE(widening_warnings(widening_with(7.224), true).empty());
  EXPECT_EQ(widening_warnings(widening_with(7.236), true).size(), 1U);
  EXPECT_FALSE(widening_beside({}, {}, {{20.0, 30.0}}, 6.0));
}

TEST(WideningBeside, OfALongSecondLesionIsNoneOfHealthyVessel) {
  // Lesions of 3 mm in a vessel of 6 mm from 20 to 30 and from 50 to 75 mm, both opened to 5.5 mm.
  centerline::LumenProfile before, peak;
  for (double s = 0.0; s <= 100.0; s += 1.0) {
    const bool is_narrow = (s > 20.0 && s < 30.0) || (s > 50.0 && s < 75.0);
    for (auto& [profile, diameter] :
         {std::pair<centerline::LumenProfile&, double>(before, is_narrow ? 3.0 : 6.0),
          {peak, is_narrow ? 5.5 : 6.3}}) {
      profile.abscissa.push_back(s);
      profile.inscribed_radius.push_back(0.5 * diameter);
      profile.section_area.push_back(0.25 * units::kPi * diameter * diameter);
    }
  }
  EXPECT_GT(widening_beside(before, peak, {{20.0, 30.0}}, 6.0)->ratio, 1.5);
  EXPECT_NEAR(widening_beside(before, peak, {{50.0, 75.0}, {20.0, 30.0}}, 6.0)->ratio, 1.05, 1e-12);
}

TEST(WideningBeside, KnowsTheLesionsOfOtherLinesAsFarAsTheyRunAlong) {
  CenterlineTree tree;
  for (const int id : {0, 1, 2}) {  // 0 and 1 share the first 20 mm; 2 begins elsewhere
    CenterlinePath path;
    path.id = id;
    for (int i = 0; i <= 40; ++i)
      path.points.push_back({id == 1 && i > 20 ? i - 20.0 : 0.0, id == 2 ? 5.0 : 0.0, double(i)});
    path.abscissa = arc_length(path.points);
    tree.paths.push_back(path);
  }
  const auto lesion = [](int id, double first, double last) {
    return nlohmann::json{{"centerline_id", id}, {"proximal_mm", first}, {"distal_mm", last}};
  };
  const nlohmann::json lesions = {lesion(0, 30.0, 35.0), lesion(1, 5.0, 8.0), lesion(1, 18.0, 25.0),
                                  lesion(1, 30.0, 32.0), lesion(2, 5.0, 8.0)};
  EXPECT_EQ(lesions_on(tree.paths[0], lesions, tree),
            (std::vector<Stretch>{{30.0, 35.0}, {5.0, 8.0}, {18.0, 20.0}}));
}

TEST(Treatment, TellsTheRangeOfTwoRunsTheSmallerFirst) {
  const nlohmann::json json =
      treatment_json(treatment(1.0, 3.0, 2.4), treatment(1.0, 3.0, 2.1), 3.0, 3.2);
  const nlohmann::json& result = json.at("result");
  EXPECT_NEAR(result.at("mld_range_mm").at(0).get<double>(), 2.1, 1e-12);
  EXPECT_NEAR(result.at("mld_range_mm").at(1).get<double>(), 2.4, 1e-12);
  EXPECT_NEAR(result.at("acute_gain_range_mm").at(0).get<double>(), 1.1, 1e-12);
  EXPECT_NEAR(result.at("acute_gain_range_mm").at(1).get<double>(), 1.4, 1e-12);
  EXPECT_NEAR(result.at("recoil_range_percent").at(0).get<double>(), 20.0, 1e-12);
  EXPECT_NEAR(result.at("recoil_range_percent").at(1).get<double>(), 30.0, 1e-12);
  EXPECT_EQ(result.at("mld_mm"), 2.4) << "the first run's";
}

TEST(Guard, AgreesUpToATenthOfTheLargerGain) {
  const Treatment first = treatment(1.0, 3.0, 2.0);  // gain 1
  EXPECT_EQ(judge(first, treatment(1.0, 3.0, 1.91), "").state, "agrees");
  EXPECT_EQ(judge(first, treatment(1.0, 3.0, 1.91), "").reason, "");
  EXPECT_EQ(judge(first, treatment(1.0, 3.0, 1.89), "").state, "differs");
  EXPECT_EQ(judge(treatment(1.0, 3.0, 1.89), first, "").state, "differs") << "in either order";
}

TEST(Guard, LooksAtTheRecoilToo) {
  // The same gain from peaks that differ.
  EXPECT_EQ(judge(treatment(1.0, 3.0, 2.0), treatment(1.0, 3.2, 2.0), "").state, "differs");
}

TEST(Guard, OfAVesselThatGainsNothingComparesRecoilWithItself) {
  EXPECT_EQ(judge(treatment(3.0, 4.0, 3.0), treatment(3.0, 4.04, 3.0), "").state, "agrees");
  EXPECT_EQ(judge(treatment(3.0, 4.0, 3.0), treatment(3.0, 4.2, 3.0), "").state, "differs");
  EXPECT_EQ(judge(treatment(3.0, 4.0, 3.0), treatment(3.0, 4.05, 3.05), "").state, "differs");
}

TEST(Guard, DoesNotCountHundredthsOfAMillimetre) {
  EXPECT_EQ(judge(treatment(3.0, 3.1, 3.01), treatment(3.0, 3.1, 3.028), "").state, "agrees");
  EXPECT_EQ(judge(treatment(3.0, 3.1, 3.01), treatment(3.0, 3.1, 3.04), "").state, "differs");
}

TEST(Guard, SaysBothGainsAndRecoilsOrWhyThereIsNoSecond) {
  const GuardVerdict apart = judge(treatment(1.0, 3.0, 2.0), treatment(1.0, 3.0, 1.5), "");
  EXPECT_NE(apart.reason.find("not determined"), std::string::npos);
  EXPECT_NE(apart.reason.find("gain of 1.000 and 0.500 mm"), std::string::npos) << apart.reason;
  EXPECT_NE(apart.reason.find("recoil of 1.000 and 1.500 mm"), std::string::npos) << apart.reason;
  const GuardVerdict failed = judge(treatment(1.0, 3.0, 2.0), std::nullopt, "it burst");
  EXPECT_EQ(failed.state, "failed");
  EXPECT_NE(failed.reason.find("it burst"), std::string::npos);
}

TEST(Treatment, WarnsOfANegativeRecoilOnly) {
  EXPECT_TRUE(treatment_warnings(treatment(1.0, 3.0, 2.9), {"agrees", ""}, {}).empty());
  const auto warnings = treatment_warnings(treatment(1.0, 3.0, 3.1), {"agrees", ""}, {});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("negative"), std::string::npos);
}

TEST(Treatment, SaysWhereWhatIsSimulatedIsNotWhatWasMeasured) {
  const TreatedMeasures before = treatment(3.4, 3.6, 3.5).before;  // 15 % of 4 mm
  EXPECT_TRUE(start_warnings(before, 24.0, 4.0).empty());
  EXPECT_TRUE(start_warnings(before, 6.0, 4.0).empty());
  EXPECT_EQ(start_warnings(before, 4.0, 4.0).size(), 1U);
  const auto warnings = start_warnings(before, 46.0, 4.0);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("narrowed by 15 %"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("by 46 %"), std::string::npos) << warnings[0];
}

TEST(TreatedSpans, AreOfTheLesionAsFarAsTheBalloonsCylinderGoes) {
  const auto spans = [](double proximal, double distal, double length) {
    return treated_spans(
        {{"lesion", {{"proximal_mm", proximal}, {"distal_mm", distal}, {"abscissa_mm", 20.0}}},
         {"site",
          {{"balloon_first_abscissa_mm", 20.0 - 0.5 * length - 1.5},
           {"balloon_last_abscissa_mm", 20.0 + 0.5 * length + 1.5}}},
         {"balloon", {{"length_mm", length}}}});
  };
  const TreatedSpans whole = spans(17.0, 24.0, 12.0);
  EXPECT_EQ(whole.lesion_first, 17.0);
  EXPECT_EQ(whole.lesion_last, 24.0);
  EXPECT_EQ(whole.segment_first, 12.5);
  EXPECT_EQ(whole.segment_last, 27.5);
  EXPECT_EQ(whole.cylinder_first, 14.0);
  EXPECT_EQ(whole.cylinder_last, 26.0);
  EXPECT_EQ(whole.untreated_mm, 0.0);
  const TreatedSpans part = spans(12.0, 21.0, 4.0);
  EXPECT_EQ(part.lesion_first, 18.0);
  EXPECT_EQ(part.lesion_last, 21.0);
  EXPECT_EQ(part.segment_first, 12.0);
  EXPECT_EQ(part.segment_last, 23.5);
  EXPECT_EQ(part.untreated_mm, 6.0);
  EXPECT_EQ(treatment_warnings(treatment(1.0, 3.0, 2.9), {"agrees", ""}, part).size(), 1U);
}

// ---- the lumen along the path ------------------------------------------------------------------

constexpr double kLength = 24.0;

CenterlinePath axis() {
  CenterlinePath path;
  for (int i = 0; i <= 80; ++i) path.points.push_back({0, 0, kLength * i / 80.0});
  path.abscissa = arc_length(path.points);
  path.inscribed_radius.assign(path.points.size(), 1.5);
  path.equivalent_radius = path.inscribed_radius;
  path.section_area.assign(path.points.size(), units::kPi * 2.25);
  return path;
}

/// An open tube along z; every other ring turned by half a step.
TriangleMesh tube(int rings, int around, const std::function<double(double)>& radius) {
  TriangleMesh mesh;
  for (int r = 0; r < rings; ++r)
    for (int i = 0; i < around; ++i) {
      const double z = kLength * r / (rings - 1),
                   angle = 2.0 * units::kPi * (i + 0.5 * (r % 2)) / around;
      mesh.vertices.push_back({radius(z) * std::cos(angle), radius(z) * std::sin(angle), z});
    }
  for (int r = 0; r + 1 < rings; ++r)
    for (int i = 0; i < around; ++i) {
      const int n = (i + 1) % around, a = r * around + i, b = r * around + n, c = a + around,
                d = b + around;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({b, d, c});
    }
  return mesh;
}

double narrowed(double z) {
  return 1.5 - 0.5 * std::exp(-std::pow((z - 9.0) / 1.5, 2)) -
         0.8 * std::exp(-std::pow((z - 17.0) / 1.0, 2));
}

TEST(TreatedLumen, IsOfTheLesionBetweenItsEdgesAndOfTheWholeSegment) {
  const TriangleMesh lumen = tube(97, 24, narrowed);
  std::vector<int> region;
  std::vector<Vec3> wall;
  for (std::size_t v = 0; v < lumen.vertices.size(); v += 2) {
    region.push_back(int(v));
    wall.push_back(lumen.vertices[v]);
  }
  const TreatedLumen treated(lumen, region, axis(), {6.0, 12.0, 3.0, 21.0}, 0.7, false);
  const TreatedMeasures measures = treated.measures(treated.profile(wall));
  EXPECT_NEAR(measures.lesion.mld_mm, 2.0, 0.03);
  EXPECT_NEAR(measures.lesion.mla_mm2, units::kPi, 0.08);
  EXPECT_NEAR(measures.segment.mld_mm, 1.4, 0.05);
  EXPECT_EQ(treated.mesh(wall).vertices, lumen.vertices);
}

TEST(TreatedLumen, EccentricityIsThatOfTheSectionAcrossThePath) {
  const TriangleMesh lumen = tube(97, 96, narrowed);
  std::vector<int> region;
  for (std::size_t v = 0; v < lumen.vertices.size(); ++v) region.push_back(int(v));
  const TreatedLumen treated(lumen, region, axis(), {6.0, 12.0, 3.0, 21.0}, 0.7, false);
  for (const double flat : {1.0, 0.8, 0.5}) {  // ellipses, aside of where the wall was
    std::vector<Vec3> wall;
    for (const Vec3& p : lumen.vertices) wall.push_back({p.x + 0.3, flat * p.y, p.z});
    const auto eccentricity = treated.eccentricity(wall, 9.0);
    ASSERT_TRUE(eccentricity);
    EXPECT_NEAR(*eccentricity, 1.0 - flat, 0.005);
  }
}

TEST(TreatedLumen, OfTheLesionAloneIsThatOfTheWholeProfile) {
  const TriangleMesh lumen = tube(97, 24, narrowed);
  std::vector<int> region;
  std::vector<Vec3> wall, balloon;
  for (std::size_t v = 0; v < lumen.vertices.size(); ++v) region.push_back(int(v));
  for (const Vec3& p : lumen.vertices) {
    wall.push_back({1.1 * p.x, 0.9 * p.y, p.z});
    if (p.z > 5.0 && p.z < 20.0) balloon.push_back({0.95 * p.x, 0.95 * p.y, p.z});
  }
  for (const auto& [first, last] : {std::pair(6.0, 12.0), std::pair(9.1, 9.1)}) {
    const TreatedLumen treated(lumen, region, axis(), {first, last, 3.0, 21.0}, 0.7, false);
    for (const auto& inside : {std::vector<Vec3>(), balloon}) {
      const centerline::Tightest whole = treated.measures(treated.profile(wall, inside)).lesion;
      const centerline::Tightest own = treated.lesion(wall, inside);
      EXPECT_NEAR(own.mld_mm, whole.mld_mm, 1e-9);
      EXPECT_NEAR(own.mla_mm2, whole.mla_mm2, 1e-9);
    }
  }
}

// A balloon of a growing width opens the lesion, while the vessel bends away and back.
TEST(TreatedLumen, FollowedFromMomentToMomentIsWhatItIsByItself) {
  const TriangleMesh lumen = tube(97, 24, narrowed);
  std::vector<int> region;
  for (std::size_t v = 0; v < lumen.vertices.size(); ++v) region.push_back(int(v));
  const TreatedLumen treated(lumen, region, axis(), {6.0, 12.0, 3.0, 21.0}, 0.7, false);
  TreatedLumen::LesionFollower follower(treated);
  constexpr int kMoments = 40;
  for (int moment = 0; moment <= kMoments; ++moment) {
    const double course = double(moment) / kMoments;
    const double width = 1.8 * std::sin(units::kPi * course),
                 bend = 1.0 * std::sin(2.0 * units::kPi * course);
    std::vector<Vec3> wall, balloon;
    for (const Vec3& p : lumen.vertices) {
      const double r = std::hypot(p.x, p.y), wide = std::max(r, std::min(width, 1.7)) / r;
      const Vec3 aside{bend * std::sin(units::kPi * p.z / kLength), 0.0, 0.0};
      wall.push_back(Vec3{wide * p.x, wide * p.y, p.z} + aside);
      if (width > 0.5 && p.z > 5.0 && p.z < 20.0)
        balloon.push_back(Vec3{width / r * p.x, width / r * p.y, p.z} + aside);
    }
    const centerline::Tightest followed = follower.measure(wall, balloon),
                               itself = treated.lesion(wall, balloon);
    EXPECT_NEAR(followed.mld_mm, itself.mld_mm, 0.01 * itself.mld_mm) << moment;
    EXPECT_NEAR(followed.mla_mm2, itself.mla_mm2, 0.02 * itself.mla_mm2) << moment;
  }
}

TEST(TreatedLumen, WhatTheImageDoesNotShowSoWideIsNoSectionOfIt) {
  const auto with_organ = [](double z) { return z > 14.0 && z < 20.0 ? 5.0 : narrowed(z); };
  const TriangleMesh lumen = tube(97, 24, with_organ);
  std::vector<int> region;
  for (std::size_t v = 0; v < lumen.vertices.size(); ++v) region.push_back(int(v));
  const TreatedLumen treated(lumen, region, axis(), {9.0, 17.0, 3.0, 21.0}, 0.7, false);
  const centerline::LumenProfile profile = treated.profile(lumen.vertices);
  ASSERT_GT(profile.abscissa.size(), 10U);
  for (std::size_t i = 0; i < profile.abscissa.size(); ++i)
    EXPECT_LT(profile.section_area[i], units::kPi * 2.25 * 2.25 + 0.1) << profile.abscissa[i];
  EXPECT_NEAR(treated.measures(profile).lesion.mld_mm, 2.0, 0.03);
  // A lesion of which nothing else is known is measured as it is; a single place, beside it.
  const auto mld = [&](double first, double last) {
    const TreatedLumen of(lumen, region, axis(), {first, last, 3.0, 21.0}, 0.7, false);
    return of.measures(of.profile(lumen.vertices)).lesion.mld_mm;
  };
  EXPECT_GT(mld(15.0, 19.0), 8.0);
  EXPECT_LT(mld(17.0, 17.0), 3.2);
}

TEST(TreatedLumen, AWallBesideItIsNoSectionOfIt) {
  // Another surface all round the second throat, which is 1.4 mm wide, a little aside.
  TriangleMesh lumen = tube(97, 24, narrowed);
  const TriangleMesh other = tube(97, 24, [](double) { return 1.9; });
  const int own = int(lumen.vertices.size());
  for (const Triangle& t : other.triangles) {
    const double z = other.vertices[std::size_t(t[0])].z;
    if (z > 14.0 && z < 20.0) lumen.triangles.push_back({own + t[0], own + t[1], own + t[2]});
  }
  lumen.vertices.insert(lumen.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (std::size_t v = std::size_t(own); v < lumen.vertices.size(); ++v)
    if (const double z = lumen.vertices[v].z; z < 14.0 || z > 20.0)
      lumen.vertices[v] = {90.0, 0.0, z};  // that no triangle has
    else
      lumen.vertices[v].x += 0.2;
  std::vector<int> region;
  std::vector<Vec3> wall;
  for (int v = 0; v < own; ++v) {
    region.push_back(v);
    wall.push_back(lumen.vertices[std::size_t(v)]);
  }
  const TreatedLumen treated(lumen, region, axis(), {6.0, 21.0, 3.0, 21.0}, 0.7, false);
  const centerline::LumenProfile profile = treated.profile(wall);
  ASSERT_GT(profile.abscissa.size(), 10U);
  for (std::size_t i = 0; i < profile.abscissa.size(); ++i) {
    const double radius = narrowed(profile.abscissa[i]);
    // The plane cuts chords: 24 around are 1.1 % less wide.
    EXPECT_NEAR(std::sqrt(profile.section_area[i] / units::kPi), radius, 0.06 * radius)
        << profile.abscissa[i];
    EXPECT_NEAR(profile.inscribed_radius[i], radius, 0.1 * radius) << profile.abscissa[i];
  }
  // A moment later, when the wall is a tenth wider, it is so in the same sections.
  for (Vec3& p : wall) p = {1.1 * p.x, 1.1 * p.y, p.z};
  const TreatedMeasures before = treated.measures(profile),
                        after = treated.measures(treated.profile(wall));
  EXPECT_NEAR(after.lesion.mld_mm, 1.1 * before.lesion.mld_mm, 0.01 * before.lesion.mld_mm);
  EXPECT_NEAR(after.lesion.mla_mm2, 1.21 * before.lesion.mla_mm2, 0.02 * before.lesion.mla_mm2);
  EXPECT_EQ(after.lesion.mla_abscissa_mm, before.lesion.mla_abscissa_mm);
  const centerline::Tightest followed = treated.lesion(wall);
  EXPECT_NEAR(followed.mld_mm, after.lesion.mld_mm, 1e-9);
}

TEST(TreatedLumen, OpenedAsFarAsItsNeighboursIsItsOwnSection) {
  // A vessel of 1.6 mm with a throat of 0.5 mm, opened to 4 mm, as wide as two vessels beside it
  // are away.
  const auto before = [](double z) {
    return 0.8 - 0.55 * std::exp(-std::pow((z - 12.0) / 3.0, 2));
  };
  TriangleMesh lumen = tube(73, 10, before);
  const std::size_t own = lumen.vertices.size();
  for (const double side : {-1.0, 1.0}) {
    TriangleMesh other = tube(97, 12, [](double) { return 0.6; });
    const int first = int(lumen.vertices.size());
    for (Vec3& p : other.vertices) lumen.vertices.push_back(p + Vec3{2.7 * side, 0.0, 0.0});
    for (const Triangle& t : other.triangles)
      lumen.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  CenterlinePath path = axis();
  for (std::size_t i = 0; i < path.points.size(); ++i)
    path.inscribed_radius[i] = path.equivalent_radius[i] = before(path.abscissa[i]);
  std::vector<int> region;
  std::vector<Vec3> wall;
  for (std::size_t v = 0; v < own; ++v) {
    region.push_back(int(v));
    const Vec3& p = lumen.vertices[v];
    const double wider = 2.0 / std::hypot(p.x, p.y);
    wall.push_back({wider * p.x, wider * p.y, p.z});
  }
  const TreatedLumen treated(lumen, region, path, {6.0, 18.0, 4.0, 20.0}, 0.25, false);
  const centerline::LumenProfile opened = treated.profile(wall);
  ASSERT_GT(opened.abscissa.size(), 50U);
  for (std::size_t i = 0; i < opened.abscissa.size(); ++i) {
    EXPECT_NEAR(std::sqrt(opened.section_area[i] / units::kPi), 2.0, 0.15) << opened.abscissa[i];
    EXPECT_NEAR(opened.inscribed_radius[i], 2.0, 0.25) << opened.abscissa[i];  // of a decagon
  }
  const centerline::Tightest lesion = treated.measures(opened).lesion;
  EXPECT_NEAR(treated.lesion(wall).mld_mm, lesion.mld_mm, 1e-9);
}

TEST(TreatedLumen, OfASinglePlaceOneSectionCountsAtAllMoments) {
  // Before, the wall around the place is not seen; after, it is.
  const TriangleMesh whole = tube(97, 24, narrowed);
  TriangleMesh torn = whole;
  std::vector<int> region;
  for (std::size_t v = 0; v < torn.vertices.size(); ++v) {
    region.push_back(int(v));
    if (std::abs(torn.vertices[v].z - 9.0) < 1.5) torn.vertices[v] = {0.0, 0.0, 36.0};
  }
  const TreatedLumen treated(torn, region, axis(), {9.0, 9.0, 3.0, 21.0}, 0.7, false);
  const auto before = treated.measures(treated.profile(torn.vertices)).lesion,
             after = treated.measures(treated.profile(whole.vertices)).lesion;
  EXPECT_EQ(after.mla_abscissa_mm, before.mla_abscissa_mm);
  EXPECT_GT(after.mld_mm, 2.1) << "as beside the throat";
}

TEST(TreatedLumen, FollowsTheWallAndNoVesselFarAway) {
  TriangleMesh lumen = tube(97, 24, narrowed);
  const std::size_t own = lumen.vertices.size();
  std::vector<int> region;
  for (std::size_t v = 0; v < own; ++v) region.push_back(int(v));
  // Another, thinner vessel beside it.
  for (std::size_t v = 0; v < own; ++v)
    lumen.vertices.push_back(
        {0.2 * lumen.vertices[v].x + 60.0, 0.2 * lumen.vertices[v].y, lumen.vertices[v].z});
  for (std::size_t t = 0, count = lumen.triangles.size(); t < count; ++t) {
    Triangle copy = lumen.triangles[t];
    for (int& v : copy) v += int(own);
    lumen.triangles.push_back(copy);
  }
  const TreatedLumen treated(lumen, region, axis(), {6.0, 12.0, 3.0, 21.0}, 0.7, false);
  std::vector<Vec3> wide;
  for (std::size_t v = 0; v < own; ++v)
    wide.push_back({1.2 * lumen.vertices[v].x, 1.2 * lumen.vertices[v].y, lumen.vertices[v].z});
  EXPECT_NEAR(treated.measures(treated.profile(wide)).lesion.mld_mm, 2.4, 0.03);
}

TEST(TreatedLumen, IsNowhereNarrowerThanTheBalloonInIt) {
  // What is seen of the wall is a crease, which reaches into the balloon's place.
  const TriangleMesh lumen = tube(97, 24, [](double) { return 1.5; });
  const TriangleMesh creased = tube(97, 24, narrowed);
  std::vector<int> region;
  for (std::size_t v = 0; v < lumen.vertices.size(); ++v) region.push_back(int(v));
  const TreatedLumen treated(lumen, region, axis(), {6.0, 12.0, 3.0, 21.0}, 0.7, false);
  const TriangleMesh balloon = tube(60, 20, [](double) { return 1.4; });
  const TreatedMeasures measures =
      treated.measures(treated.profile(creased.vertices, balloon.vertices));
  EXPECT_NEAR(measures.lesion.mld_mm, 2.8, 0.03);
  EXPECT_NEAR(treated.measures(treated.profile(creased.vertices)).lesion.mld_mm, 2.0, 0.05);
  // Beyond its cylinder the balloon's end would be taken for a wider section than it has.
  const TreatedSpans elsewhere{6.0, 12.0, 3.0, 21.0, 0.0, 15.0, 20.0};
  const TreatedLumen beside(lumen, region, axis(), elsewhere, 0.7, false);
  EXPECT_NEAR(beside.measures(beside.profile(creased.vertices, balloon.vertices)).lesion.mld_mm,
              2.0, 0.05);
  const TriangleMesh thin = tube(60, 20, [](double) { return 0.4; });
  EXPECT_NEAR(treated.measures(treated.profile(creased.vertices, thin.vertices)).lesion.mld_mm, 2.0,
              0.05);
  // Where no section of the wall is seen a thin balloon is no lumen.
  std::vector<Vec3> torn = creased.vertices;
  for (Vec3& p : torn)
    if (p.z > 5.0 && p.z < 13.0) p = {0.0, 0.0, 60.0};
  const centerline::LumenProfile seen = treated.profile(torn);
  EXPECT_LT(seen.abscissa.size(), treated.profile(creased.vertices).abscissa.size());
  EXPECT_EQ(treated.profile(torn, thin.vertices).abscissa, seen.abscissa);
}

TEST(TreatedLumen, FollowsAWallThatIsPushedOffItsOldLine) {
  const TriangleMesh lumen = tube(97, 24, narrowed);
  std::vector<int> region;
  std::vector<Vec3> aside;
  for (std::size_t v = 0; v < lumen.vertices.size(); ++v) {
    const Vec3& p = lumen.vertices[v];
    region.push_back(int(v));
    aside.push_back(p + Vec3{2.5 * std::exp(-std::pow((p.z - 9.0) / 6.0, 2)), 0, 0});
  }
  const TreatedLumen treated(lumen, region, axis(), {6.0, 12.0, 3.0, 21.0}, 0.7, false);
  const TreatedMeasures measures = treated.measures(treated.profile(aside));
  EXPECT_NEAR(measures.lesion.mld_mm, 2.0, 0.05);  // the slope of the push is zero at the throat
  EXPECT_NEAR(measures.lesion.mla_mm2, units::kPi, 0.15);
}

TEST(TreatedLumen, OfAGivenCoarseMeshCountsTheMiddlesOfItsEdges) {
  const TriangleMesh lumen = tube(25, 12, narrowed);
  std::vector<int> region;
  for (std::size_t v = 0; v < lumen.vertices.size(); ++v) region.push_back(int(v));
  const TreatedSpans spans{6.0, 12.0, 3.0, 21.0};
  const TreatedLumen kept(lumen, region, axis(), spans, 0.7, true);
  const TreatedMeasures measures = kept.measures(kept.profile(lumen.vertices));
  EXPECT_NEAR(measures.lesion.mld_mm, 2.0, 0.12);  // the flat triangles lie inside
}

TEST(ProfileCsv, HasARowForEachPlaceAndAnEmptyCellWhereNothingIsSeen) {
  const centerline::LumenProfile before{{1.0, 2.0}, {0.5, 0.6}, {units::kPi, units::kPi}},
      peak{{1.0}, {0.7}, {units::kPi}}, after{{2.0}, {0.8}, {4.0 * units::kPi}};
  EXPECT_EQ(profile_csv(before, peak, after),
            "abscissa_mm,inscribed_diameter_before_mm,equivalent_diameter_before_mm,"
            "inscribed_diameter_after_mm,equivalent_diameter_after_mm,"
            "inscribed_diameter_peak_mm,equivalent_diameter_peak_mm\n"
            "1.0000,1.00000,2.00000,,,1.40000,2.00000\n"
            "2.0000,1.20000,2.00000,1.60000,4.00000,,\n");
}

}  // namespace
}  // namespace angio::pipeline

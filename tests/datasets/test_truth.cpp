#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/units.hpp"
#include "datasets/detail/anatomy.hpp"
#include "datasets/detail/truth.hpp"
#include "datasets/phantom.hpp"
#include "tests/datasets/mesh_probe.hpp"

namespace angio::datasets {
namespace {

using units::kPi;

PhantomTruth truth_of(std::string_view description) {
  return datasets::detail::derive_truth(datasets::detail::make_anatomy(parse_phantom(description)));
}

TEST(PhantomTruth, AStraightTubeIsACylinder) {
  const PhantomTruth truth = truth_of("straight,radius=1.2,length=30");
  EXPECT_FALSE(truth.has_lesion);
  EXPECT_NEAR(truth.mld_mm, 2.4, 1e-12);
  ASSERT_EQ(truth.tree.paths.size(), 1u);
  const CenterlinePath& path = truth.tree.paths[0];
  EXPECT_NEAR(path.abscissa.back(), 30.0, 1e-9);
  for (std::size_t p = 0; p < path.points.size(); ++p) {
    EXPECT_NEAR(path.inscribed_radius[p], 1.2, 1e-12);
    EXPECT_NEAR(path.section_area[p], kPi * 1.2 * 1.2, 1e-6);
    EXPECT_NEAR(path.equivalent_radius[p], 1.2, 1e-6);
  }
}

TEST(PhantomTruth, AnEccentricStenosisLeavesACircle) {
  const PhantomTruth truth = truth_of("unilateral,stenosis=60,radius=1.5");
  ASSERT_TRUE(truth.has_lesion);
  EXPECT_NEAR(truth.mld_mm, 2 * 0.6, 1e-9);
  EXPECT_NEAR(truth.mla_mm2, kPi * 0.6 * 0.6, 1e-4);
  EXPECT_NEAR(truth.reference_diameter_mm, 3.0, 1e-12);
  EXPECT_NEAR(truth.diameter_stenosis_percent, 60.0, 1e-9);
  // The lumen keeps touching the healthy wall: its centre is off the axis by R - r.
  EXPECT_NEAR(std::hypot(truth.lesion_point.x, truth.lesion_point.y), 0.9, 1e-9);
}

TEST(PhantomTruth, ATwoSidedStenosisLeavesAStadium) {
  const double healthy = 1.5, radius = 0.6;
  const PhantomTruth truth = truth_of("bilateral,stenosis=60,radius=1.5");
  EXPECT_NEAR(truth.mld_mm, 2 * radius, 1e-9);
  EXPECT_NEAR(truth.mla_mm2, kPi * radius * radius + 4 * radius * (healthy - radius), 2e-3);
  EXPECT_NEAR(std::hypot(truth.lesion_point.x, truth.lesion_point.y), 0.0, 1e-9);
}

TEST(PhantomTruth, TheStenosisIsTheOneAskedForInEveryVessel) {
  for (const char* name : {"unilateral", "bilateral", "ytype", "coronary", "concentric", "tandem",
                           "helix", "torus", "trifurcation", "aneurysm"})
    for (const char* percent : {"30", "95"}) {
      const PhantomTruth truth = truth_of(std::string(name) + ",stenosis=" + percent);
      // Taper moves the narrowest place a little off the middle of the lesion.
      EXPECT_NEAR(truth.diameter_stenosis_percent, std::stod(percent), 0.1) << name;
      const CenterlineSample at =
          sample(truth.tree.paths[std::size_t(truth.lesion_path)], truth.lesion_abscissa_mm);
      EXPECT_NEAR(distance(at.point, truth.lesion_point), 0.0, 1e-9);
      EXPECT_NEAR(2 * at.inscribed_radius, truth.mld_mm, 1e-9);
    }
}

TEST(PhantomTruth, NoStenosisIsNoLesion) {
  for (const char* name : {"unilateral", "bilateral", "ytype", "coronary", "concentric", "tandem",
                           "helix", "torus", "trifurcation", "aneurysm"})
    EXPECT_FALSE(truth_of(std::string(name) + ",stenosis=0").has_lesion) << name;
}

TEST(PhantomTruth, DaughtersFollowMurraysLaw) {
  const PhantomTruth truth = truth_of("ytype,stenosis=0");
  const double parent = truth.tree.paths[0].inscribed_radius.front();
  double cubes = 0.0;
  for (const CenterlinePath& path : truth.tree.paths)
    cubes += std::pow(path.inscribed_radius.back(), 3);
  EXPECT_NEAR(cubes, std::pow(parent, 3), 1e-9);
}

TEST(PhantomTruth, TheCoronaryHasTheSizeOfALeftCoronary) {
  const PhantomTruth truth = truth_of("coronary");
  ASSERT_EQ(truth.tree.paths.size(), 3u);
  const CenterlinePath& lad = truth.tree.paths[0];
  EXPECT_GT(2 * lad.inscribed_radius.front(), 4.0);
  EXPECT_LT(2 * lad.inscribed_radius.front(), 4.5);
  for (const CenterlinePath& path : truth.tree.paths) {
    EXPECT_GE(2 * path.inscribed_radius.back(), 1.4);
    EXPECT_LE(2 * path.inscribed_radius.back(), 2.2);
  }
  EXPECT_EQ(truth.lesion_path, 0);
}

TEST(PhantomTruth, PathsShareTheirBeginningsAndTractsCoverThem) {
  const PhantomTruth truth = truth_of("coronary");
  const auto& paths = truth.tree.paths;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    EXPECT_EQ(paths[i].id, int(i));
    EXPECT_EQ(paths[i].points.front(), paths[0].points.front());
    EXPECT_LE(paths[i].abscissa.back(), paths[0].abscissa.back());
    ASSERT_FALSE(paths[i].tracts.empty());
    EXPECT_EQ(paths[i].tracts.front().first_point, 0);
    EXPECT_EQ(paths[i].tracts.back().last_point, int(paths[i].points.size()) - 1);
    for (std::size_t t = 1; t < paths[i].tracts.size(); ++t)
      EXPECT_EQ(paths[i].tracts[t].first_point, paths[i].tracts[t - 1].last_point);
  }
  // Left main, both bifurcations, and the LAD between them are in two paths.
  EXPECT_EQ(paths[0].tracts[2].group_id, paths[1].tracts[2].group_id);
  EXPECT_FALSE(paths[0].tracts[2].blanking);
  EXPECT_TRUE(paths[0].tracts[1].blanking);
}

TEST(PhantomTruth, InscribedRadiiAreDistancesToTheSurface) {
  for (const char* name : {"unilateral", "bilateral", "ytype", "coronary", "concentric", "tandem",
                           "helix", "torus", "trifurcation", "aneurysm"}) {
    const Phantom phantom = make_phantom_surface(parse_phantom(name));
    for (const CenterlinePath& path : phantom.truth.tree.paths)
      for (std::size_t p = 0; p < path.points.size(); p += 20) {
        const double radius = path.inscribed_radius[p];
        const bool is_near_end = path.abscissa[p] < 1.2 * radius ||
                                 path.abscissa.back() - path.abscissa[p] < 1.2 * radius;
        if (is_near_end) continue;
        // Flat triangles lie inside the round wall by edge^2 / (8 r): 3 % where an edge is half r.
        EXPECT_NEAR(tests::distance_to_mesh(phantom.surface, path.points[p]), radius,
                    0.035 * radius)
            << name << " path " << path.id << " at " << path.abscissa[p] << " mm";
      }
  }
}

TEST(PhantomTruth, ATandemHasTwoLesionsTheSecondThreeQuartersAsDeep) {
  const PhantomTruth truth = truth_of("tandem,stenosis=60");
  ASSERT_EQ(truth.lesions.size(), 2u);
  EXPECT_NEAR(truth.lesions[0].diameter_stenosis_percent, 60.0, 0.02);
  EXPECT_NEAR(truth.lesions[1].diameter_stenosis_percent, 45.0, 0.02);
  EXPECT_EQ(truth.mld_mm, truth.lesions[0].mld_mm);
  EXPECT_NEAR(truth.lesions[1].lesion_abscissa_mm - truth.lesions[0].lesion_abscissa_mm, 50.0 / 3,
              0.6);  // the line bends aside in both lesions and is a little longer
}

TEST(PhantomTruth, AHelixBendsEverywhereAlike) {
  const PhantomTruth truth = truth_of("helix,stenosis=0,radius=1.5,length=60");
  const std::vector<Vec3>& points = truth.tree.paths[0].points;
  const double coil = 5.3 * 1.5, rise = coil / kPi;
  const double curvature = coil / (coil * coil + rise * rise);
  for (std::size_t p = 12; p + 12 < points.size(); p += 10) {
    const Vec3 before = points[p] - points[p - 10], after = points[p + 10] - points[p];
    const double turned = std::acos(dot(normalized(before), normalized(after)));
    EXPECT_NEAR(turned / (0.5 * (norm(before) + norm(after))), curvature, 0.02 * curvature);
  }
}

TEST(PhantomTruth, ATrifurcationIsOneBranchingWithThreeEqualDaughters) {
  const PhantomTruth truth = truth_of("trifurcation,stenosis=0");
  ASSERT_EQ(truth.tree.paths.size(), 3u);
  double cubes = 0.0;
  for (const CenterlinePath& path : truth.tree.paths) {
    cubes += std::pow(path.inscribed_radius.back(), 3);
    ASSERT_EQ(path.tracts.size(), 3u);
    EXPECT_TRUE(path.tracts[1].blanking);
    EXPECT_EQ(path.tracts[1].group_id, truth.tree.paths[0].tracts[1].group_id);
  }
  EXPECT_NEAR(cubes, std::pow(1.8, 3), 1e-6);
}

TEST(PhantomTruth, AnAneurysmHasNoLineAndItsNeckBelongsToNoBranch) {
  const PhantomTruth truth = truth_of("aneurysm,stenosis=60");
  ASSERT_EQ(truth.tree.paths.size(), 1u);
  ASSERT_EQ(truth.tree.paths[0].tracts.size(), 3u);
  EXPECT_TRUE(truth.tree.paths[0].tracts[1].blanking);
  EXPECT_NEAR(truth.mld_mm, 1.2, 1e-3);  // no sample lies exactly in the middle
}

TEST(PhantomTruth, SectionAreasAreThoseOfTheSurface) {
  for (const char* name : {"unilateral", "bilateral", "coronary"}) {
    const Phantom phantom = make_phantom_surface(parse_phantom(name));
    const PhantomTruth& truth = phantom.truth;
    const CenterlinePath& path = truth.tree.paths[std::size_t(truth.lesion_path)];
    const Vec3 tangent = sample(path, truth.lesion_abscissa_mm).tangent;
    EXPECT_NEAR(tests::section_area(phantom.surface, truth.lesion_point, tangent, 3.0),
                truth.mla_mm2, 0.03 * truth.mla_mm2)
        << name;
  }
}

}  // namespace
}  // namespace angio::datasets

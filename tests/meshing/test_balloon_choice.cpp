#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "air_mesh/build/gap_boundary.hpp"
#include "core/error.hpp"
#include "meshing/detail/winding.hpp"
#include "meshing/meshing.hpp"
#include "testing/meshing/placed_balloon.hpp"
#include "testing/shapes.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

using test::forked;
using test::place;
using test::PlacedCase;
using test::stenosed;
using test::stenosed_tube;
using test::with_cones;

TEST(PlaceBalloon, StaysADiameterInsideTheOutletHoweverItIsClosed) {
  constexpr double kRadius = 1.5;
  const auto vessel = test::make_tube(20.0, 0.3, [](double) { return kRadius; });
  for (const int triangle_count : {0, 2000}) {
    LumenMeshOptions options;
    options.triangle_count = triangle_count;
    const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, options);
    const BalloonSetup setup = place_balloon(lumen, vessel.tree, vessel.tree.paths[0], 14.0, 10.0,
                                             2.0 * kRadius, {.length_mm = 10.0});
    const auto highest = [](const TriangleMesh& mesh) {
      double high = mesh.vertices[0].z;
      for (const Vec3& p : mesh.vertices) high = std::max(high, p.z);
      return high;
    };
    EXPECT_NEAR(highest(lumen.open) - highest(setup.balloon.start), 2.0 * kRadius, 0.1)
        << triangle_count;
  }
}

TEST(PlaceBalloon, IsThinnerWhereTheLumenIs) {
  const PlacedCase tight = place(stenosed_tube(0.75), 18.0, 8.0, 3.0);
  const auto ring_radius = [&](std::size_t ring) {
    const auto& x = tight.setup.balloon.start.vertices;
    return 0.5 * distance(x[20 * ring], x[20 * ring + 10]);
  };
  EXPECT_NEAR(ring_radius(8), 0.45, 0.01);
  EXPECT_LT(ring_radius(16), 0.85 * 0.375 + 0.02);
}

TEST(PlaceBalloon, ReachesIntoTheSideBranch) {
  EXPECT_EQ(boundary_loops(forked().setup.region.mesh).size(), 3U);
  const std::set<int> groups(forked().setup.region.group.begin(),
                             forked().setup.region.group.end());
  EXPECT_EQ(groups, (std::set<int>{0, 1, 2}));
}

TEST(PlaceBalloon, TakesTheReferenceDiameterToTheNextQuarter) {
  EXPECT_DOUBLE_EQ(stenosed().setup.balloon.nominal_diameter_mm, 3.0);
  EXPECT_DOUBLE_EQ(place(stenosed_tube(), 18.0, 8.0, 2.85).setup.balloon.nominal_diameter_mm, 2.75);
  EXPECT_DOUBLE_EQ(place(stenosed_tube(), 18.0, 8.0, 0.5).setup.balloon.nominal_diameter_mm, 1.0);
}

TEST(PlaceBalloon, CoversTheLesionByThreeMillimetres) {
  EXPECT_DOUBLE_EQ(stenosed().setup.balloon.length_mm, 14.0);
  EXPECT_DOUBLE_EQ(place(stenosed_tube(), 18.0, 6.3, 3.0).setup.balloon.length_mm, 13.0);
  EXPECT_DOUBLE_EQ(place(stenosed_tube(), 18.0, 0.0, 3.0).setup.balloon.length_mm, 8.0);
}

TEST(PlaceBalloon, DoesNotReachAroundAUTurn) {
  // A half circle of radius 6 mm: 17 mm of lesion and shoulders turn by 160 degrees.
  const PlacedCase turned = place(test::make_arc(1.2, 6.0, 3.0, 0.25), 9.0, 11.0, 2.5);
  const std::vector<Vec3>& line = turned.setup.balloon.guidewire;
  const Vec3 first = normalized(line[1] - line[0]),
             last = normalized(line.back() - line[line.size() - 2]);
  EXPECT_GT(dot(first, last), -0.05);
  EXPECT_THAT(turned.setup.warnings, testing::Contains(testing::HasSubstr("turns")));
}

TEST(PlaceBalloon, IsNotLongerThanBalloonsOfItsDiameter) {
  const auto long_vessel = test::make_tube(70.0, 0.4, [](double) { return 1.5; });
  EXPECT_DOUBLE_EQ(place(long_vessel, 35.0, 50.0, 3.0).setup.balloon.length_mm, 30.0);
}

TEST(PlaceBalloon, AWiderOneHasAThickerProfileAndIsAsLongAsWide) {
  const auto wide = test::make_tube(90.0, 1.0, [](double) { return 8.0; });
  const Balloon balloon = place(wide, 45.0, 4.0, 16.0).setup.balloon;
  EXPECT_DOUBLE_EQ(balloon.length_mm, 16.0);
  EXPECT_NEAR(balloon.start_diameter_mm, 0.9 * std::pow(4.0, 2.0 / 3.0), 1e-9);
}

TEST(PlaceBalloon, TakesAnySizeThatIsAskedFor) {
  BalloonOptions options = with_cones();
  options.nominal_diameter_mm = 2.3;
  options.length_mm = 9.0;
  options.start_diameter_mm = 0.7;
  options.ring_count = 41;
  options.ring_vertex_count = 15;
  options.guidewire_node_count = 7;
  const Balloon balloon = place(stenosed_tube(), 18.0, 8.0, 3.0, options).setup.balloon;
  EXPECT_EQ(balloon.start.vertices.size(), 41U * 15U + 2U);
  EXPECT_EQ(balloon.guidewire.size(), 7U);
  EXPECT_DOUBLE_EQ(balloon.nominal_diameter_mm, 2.3);
  EXPECT_DOUBLE_EQ(balloon.length_mm, 9.0);
  EXPECT_NEAR(balloon.start_diameter_mm, 0.7, 1e-9);
  // Cones of 37.5 degrees from 1.15 mm down to the shaft's 0.3 mm, and necks of 0.3 mm.
  const double ends = 2.0 * (0.85 / std::tan(37.5 * pi / 180.0) + 0.3);
  EXPECT_NEAR(distance(balloon.rest[balloon.rest.size() - 2], balloon.rest.back()), 9.0 + ends,
              1e-9);
  options.ends = BalloonEnds::hemispheres;
  const Balloon paper = place(stenosed_tube(), 18.0, 8.0, 3.0, options).setup.balloon;
  EXPECT_DOUBLE_EQ(distance(paper.rest[paper.rest.size() - 2], paper.rest.back()), 11.3);
}

TEST(PlaceBalloon, IsShortenedWithAWarningWhereTheVesselIsShort) {
  const PlacedCase tight =
      place(test::make_tube(18.0, 0.3, test::stenosis(1.5, 9.0, 4.0, 0.5)), 9.0, 8.0, 3.0);
  EXPECT_LT(tight.setup.balloon.length_mm, 14.0);
  EXPECT_GT(tight.setup.balloon.length_mm, 2.0);
  EXPECT_THAT(tight.setup.warnings, testing::Contains(testing::HasSubstr("shortened")));
}

TEST(PlaceBalloon, ShorterThanAnyThatIsSoldIsSaid) {
  for (const auto& [length, is_said] : {std::pair{15.0, true}, {22.0, false}}) {
    const PlacedCase cut =
        place(test::make_tube(length, 0.3, test::stenosis(1.5, 0.5 * length, 4.0, 0.5)),
              0.5 * length, 8.0, 3.0);
    EXPECT_LT(cut.setup.balloon.length_mm, 14.0);
    EXPECT_EQ(cut.setup.balloon.length_mm < 5.0, is_said);
    const auto said = testing::Contains(testing::HasSubstr("none so short is sold"));
    if (is_said)
      EXPECT_THAT(cut.setup.warnings, said);
    else
      EXPECT_THAT(cut.setup.warnings, testing::Not(said));
  }
}

TEST(PlaceBalloon, WhereNoneFitsIsAnInputError) {
  const auto throat = test::make_tube(24.0, 0.08, test::stenosis(0.8, 12.0, 4.0, 0.86));
  const LumenMesh lumen = mesh_lumen(throat.level_set, throat.tree, {});
  EXPECT_THROW(place_balloon(lumen, throat.tree, throat.tree.paths[0], 12.0, 4.0, 1.6, {}),
               InputError);
  const auto shorty = test::make_tube(9.0, 0.3, [](double) { return 1.5; });
  const LumenMesh short_lumen = mesh_lumen(shorty.level_set, shorty.tree, {});
  EXPECT_THROW(place_balloon(short_lumen, shorty.tree, shorty.tree.paths[0], 4.5, 2.0, 3.0, {}),
               InputError);
}

TEST(PlaceBalloon, NamesNoPlaceWhereThereIsNone) {
  const auto stub = test::make_tube(5.0, 0.3, [](double) { return 1.5; });
  const LumenMesh lumen = mesh_lumen(stub.level_set, stub.tree, {});
  try {
    place_balloon(lumen, stub.tree, stub.tree.paths[0], 2.5, 2.0, 3.0, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("the vessel is too short for a balloon"));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("Choose a place from")));
  }
}

/// Vessels side by side, fused into one flat lumen: half axes 2.6 and 1.1 mm, 30 mm along z, with a
/// bulge of the upper wall over the middle. The first line runs in the lumen's middle, the others
/// leave it at 2 mm and run 1.3 mm beside it.
struct FusedVessels {
  LumenMesh lumen;
  CenterlineTree tree;
};
FusedVessels fused_vessels(int line_count) {
  constexpr double kLength = 30.0, kBulge = 1.2;  // mm
  FusedVessels fused;
  TriangleMesh& wall = fused.lumen.open;
  wall = tests::make_tube(1.0, kLength, 121, 48);
  for (Vec3& p : wall.vertices) {
    p = {2.6 * p.x, 1.1 * p.y, p.z};
    const double off = std::hypot(p.x, p.z - 0.5 * kLength) / kBulge;
    if (p.y > 0.0 && off < 1.0) p.y += 0.5 * (1.0 + std::cos(pi * off));
  }
  fused.lumen.capped = wall;
  fused.lumen.inlet_outlet_id.assign(wall.vertices.size(), 0);
  for (int line = 0; line < line_count; ++line) {
    const double aside = line == 0 ? 0.0 : line == 1 ? 1.3 : -1.3;
    std::vector<Vec3> points;
    for (double z = 0.0; z <= kLength; z += 0.25)
      points.push_back({aside * std::clamp((z - 2.0) / 3.0, 0.0, 1.0), 0.0, z});
    const std::vector<double> radii(points.size(), line == 0 ? 1.1 : 0.9);
    fused.tree.paths.push_back(test::make_path(line, std::move(points), radii));
  }
  return fused;
}

BalloonSetup place_in(const FusedVessels& fused) {
  BalloonOptions options = with_cones();
  options.length_mm = 4.0;
  return place_balloon(fused.lumen, fused.tree, fused.tree.paths[0], 15.0, 2.0, 2.0, options);
}

TEST(PlaceBalloon, BesideAScrapOfWallIsAnInputError) {
  const BalloonSetup alone = place_in(fused_vessels(1));
  const auto gap = air_mesh::close_region(alone.region.mesh);
  ASSERT_TRUE(gap.has_value());
  const detail::Winding around_it(gap->shell);
  for (const Vec3& p : alone.balloon.start.vertices) EXPECT_EQ(around_it.at(p), 1);
  // Where others run beside it, the wall at both sides is theirs. What is left is the bulge, which
  // closes clear of the balloon and beside it.
  try {
    place_in(fused_vessels(3));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("the wall around the balloon"));
  }
}

TEST(BalloonOptions, DefaultsAreValid) { EXPECT_NO_THROW(BalloonOptions{}.validate()); }

TEST(BalloonOptions, NamesWhatIsOutOfRange) {
  BalloonOptions options;
  options.ring_count = 3;
  try {
    options.validate();
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("ring_count"));
  }
}

TEST(PlaceBalloon, InALumenWithExtensionsIsWhatItIsWithout) {
  const test::Vessel vessel = stenosed_tube();
  LumenMeshOptions options;
  options.extension_diameters = 3.0;
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, options);
  const BalloonSetup setup =
      place_balloon(lumen, vessel.tree, vessel.tree.paths[0], 18.0, 8.0, 3.0, with_cones());
  EXPECT_EQ(count_intersections(setup.balloon.start, lumen.capped), 0);
  EXPECT_EQ(setup.balloon.start.vertices, stenosed().setup.balloon.start.vertices);
  EXPECT_EQ(setup.region.lumen_vertex, stenosed().setup.region.lumen_vertex);
}

}  // namespace
}  // namespace angio::meshing

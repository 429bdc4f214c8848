#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "air_mesh/build/build_air.hpp"
#include "air_mesh/build/gap_boundary.hpp"
#include "air_mesh/build/gap_mesh.hpp"
#include "core/error.hpp"
#include "meshing/detail/winding.hpp"
#include "meshing/meshing.hpp"
#include "testing/meshing/placed_balloon.hpp"
#include "testing/shapes.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

using test::place;
using test::stenosed_tube;
using test::with_cones;
using Case = test::PlacedCase;

/// Placed once; many tests look at it.
const Case& stenosed() {
  static const Case kCase = place(stenosed_tube(), 18.0, 8.0, 3.0);
  return kCase;
}
const Case& bent() {
  static const Case kCase = place(test::make_arc(1.5, 7.0, 2.8, 0.3), 9.8, 2.0, 3.0);
  return kCase;
}
const Case& forked() {
  static const Case kCase = place(test::make_fork(1.5, 1.2, 16.0, 16.0, 0.6, 0.3), 16.0, 2.0, 2.5);
  return kCase;
}

class PlacedBalloon : public testing::TestWithParam<const Case& (*)()> {
 protected:
  const Case& placed() const { return GetParam()(); }
  const Balloon& balloon() const { return placed().setup.balloon; }
  const ContactRegion& region() const { return placed().setup.region; }
  const TetMesh& air() const { return placed().setup.air.tets; }
};

TEST_P(PlacedBalloon, HasItsCounts) {
  EXPECT_EQ(balloon().start.vertices.size(), 642U);  // 32 rings of 20, and the poles
  EXPECT_EQ(balloon().start.triangles.size(), 1280U);
  EXPECT_EQ(balloon().rest.size(), 642U);
  EXPECT_EQ(balloon().guidewire.size(), 24U);
}

/// Of the unloaded balloon: radius and place of the ring's vertices.
struct RestRing {
  double z, radius;
};
std::vector<RestRing> rest_rings(const Balloon& balloon) {
  std::vector<RestRing> rings;
  for (int i = 0; i < balloon.ring_count; ++i) {
    const Vec3& p = balloon.rest[std::size_t(i * balloon.ring_vertex_count)];
    rings.push_back({p.z, std::hypot(p.x, p.y)});
  }
  return rings;
}

TEST_P(PlacedBalloon, IsACylinderBetweenConesThatEndInNecksOnTheShaft) {
  const std::vector<RestRing> rings = rest_rings(balloon());
  const double widest = rings[rings.size() / 2].radius;
  double cylinder = 0.0;
  int cones = 0;
  for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
    const double rise = rings[i + 1].radius - rings[i].radius, way = rings[i + 1].z - rings[i].z;
    if (std::abs(rise) > 1e-9) {
      const double degrees = std::atan2(std::abs(rise), way) * 180.0 / pi;
      EXPECT_GT(degrees, 30.0);
      EXPECT_LT(degrees, 45.0);
      ++cones;
    } else if (rings[i].radius > widest - 1e-9) {
      cylinder += way;
    } else {
      EXPECT_TRUE(i == 0 || i + 2 == rings.size());  // a neck
      EXPECT_NEAR(rings[i].radius, 0.3, 0.01);       // of the shaft
    }
  }
  EXPECT_GE(cones, 4);
  EXPECT_NEAR(cylinder, balloon().length_mm, 1e-9);
}

// Frusta and cylinders of circles: the polygons have their areas, the facets between two of
// different size a little less.
TEST_P(PlacedBalloon, HasTheVolumeOfItsShapeUnloaded) {
  double volume = 0.0;
  const std::vector<RestRing> rings = rest_rings(balloon());
  const double angle = 2.0 * pi / balloon().ring_vertex_count;
  const double to_circle = std::sqrt(std::sin(angle) / angle);
  for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
    const double a = to_circle * rings[i].radius, b = to_circle * rings[i + 1].radius;
    volume += pi / 3.0 * (a * a + a * b + b * b) * (rings[i + 1].z - rings[i].z);
  }
  EXPECT_NEAR(enclosed_volume({balloon().rest, balloon().start.triangles}) / volume, 1.0, 1e-6);
}

TEST_P(PlacedBalloon, IsTiedAtItsNecksAndSlidesAtTheDistalOne) {
  const auto n = std::size_t(balloon().ring_vertex_count), all = balloon().rest.size();
  ASSERT_EQ(balloon().fixed.size(), all);
  ASSERT_EQ(balloon().sliding.size(), all);
  for (std::size_t v = 0; v < all; ++v) {
    const bool is_proximal = v < 2 * n || v == all - 2;
    const bool is_distal = (v >= all - 2 - 2 * n && v < all - 2) || v == all - 1;
    EXPECT_EQ(balloon().fixed[v] != 0, is_proximal || is_distal) << v;
    EXPECT_EQ(balloon().sliding[v] != 0, is_distal) << v;
  }
}

TEST_P(PlacedBalloon, HasTrianglesOfGoodShapeUnloaded) {
  double least = 180.0;
  for (const Triangle& t : balloon().start.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = balloon().rest[std::size_t(t[k])];
      const Vec3 a = balloon().rest[std::size_t(t[(k + 1) % 3])] - p,
                 b = balloon().rest[std::size_t(t[(k + 2) % 3])] - p;
      least = std::min(least, std::atan2(norm(cross(a, b)), dot(a, b)) * 180.0 / pi);
    }
  EXPECT_GT(least, 15.0);
}

TEST_P(PlacedBalloon, IsAClosedSphereTopologically) {
  const SurfaceTopology topology = surface_topology(balloon().start);
  EXPECT_TRUE(topology.is_closed());
  EXPECT_EQ(topology.component_count, 1);
  EXPECT_EQ(topology.euler_number, 2);
  EXPECT_GT(enclosed_volume(balloon().start), 0.0);
  EXPECT_GT(enclosed_volume({balloon().rest, balloon().start.triangles}), 0.0);
}

TEST_P(PlacedBalloon, HasItsPolesLastAndTheGuidewireBetweenThem) {
  const auto& x = balloon().start.vertices;
  EXPECT_EQ(balloon().guidewire.front(), x[x.size() - 2]);
  EXPECT_LT(distance(balloon().guidewire.back(), x.back()), 1e-9);
  const CenterlinePath& path = placed().vessel.tree.paths[0];
  EXPECT_LT(project(path, x[x.size() - 2]), project(path, x.back()));  // proximal first
}

TEST_P(PlacedBalloon, StaysClearOfTheWall) {
  EXPECT_EQ(count_intersections(balloon().start, placed().lumen.capped), 0);
  EXPECT_EQ(count_self_intersections(balloon().start), 0);
  for (const Vec3& p : balloon().start.vertices)
    EXPECT_LT(placed().vessel.signed_distance(p), -0.02);
}

TEST_P(PlacedBalloon, IsAsLongAtTheStartAsAtRest) {
  const double start = arc_length(balloon().guidewire).back();
  const auto& rest = balloon().rest;
  const double length = distance(rest[rest.size() - 2], rest.back());
  EXPECT_NEAR(start / length, 1.0, 0.01);  // the guidewire's 23 chords cut bends a little
}

TEST_P(PlacedBalloon, HasRestSectionsOfTheNominalArea) {
  const int n = 20;
  const int ring = 13;
  double area = 0.0;
  for (int k = 0; k < n; ++k) {
    const Vec3& a = balloon().rest[std::size_t(ring * n + k)];
    const Vec3& b = balloon().rest[std::size_t(ring * n + (k + 1) % n)];
    area += 0.5 * (a.x * b.y - a.y * b.x);
  }
  const double radius = 0.5 * balloon().nominal_diameter_mm;
  EXPECT_NEAR(area / (pi * radius * radius), 1.0, 1e-9);
}

TEST_P(PlacedBalloon, HasARegionInOnePieceWithAFixedRim) {
  const SurfaceTopology topology = surface_topology(region().mesh);
  EXPECT_EQ(topology.component_count, 1);
  EXPECT_EQ(topology.nonmanifold_edge_count, 0);
  const auto loops = boundary_loops(region().mesh);
  // An open surface without handles: a sphere with one hole per loop.
  EXPECT_EQ(topology.euler_number, 2 - int(loops.size()));
  std::set<int> rim;
  for (const auto& loop : loops) rim.insert(loop.begin(), loop.end());
  for (std::size_t v = 0; v < region().mesh.vertices.size(); ++v)
    EXPECT_EQ(region().fixed[v] != 0, rim.contains(int(v)));
}

TEST_P(PlacedBalloon, HasARegionMadeOfTheLumen) {
  const ContactRegion& r = region();
  ASSERT_EQ(r.lumen_vertex.size(), r.mesh.vertices.size());
  ASSERT_EQ(r.group.size(), r.mesh.vertices.size());
  for (std::size_t v = 0; v < r.lumen_vertex.size(); ++v) {
    EXPECT_EQ(r.mesh.vertices[v], placed().lumen.open.vertices[std::size_t(r.lumen_vertex[v])]);
    EXPECT_NEAR(r.abscissa[v], project(placed().vessel.tree.paths[0], r.mesh.vertices[v]), 1e-9);
  }
  const std::set<Triangle> all(placed().lumen.open.triangles.begin(),
                               placed().lumen.open.triangles.end());
  for (const Triangle& t : r.mesh.triangles)
    EXPECT_TRUE(all.contains({r.lumen_vertex[std::size_t(t[0])], r.lumen_vertex[std::size_t(t[1])],
                              r.lumen_vertex[std::size_t(t[2])]}));
}

TEST_P(PlacedBalloon, HasARegionThatReachesPastThePoles) {
  const CenterlinePath& path = placed().vessel.tree.paths[0];
  const auto& x = balloon().start.vertices;
  const auto [low, high] = std::minmax_element(region().abscissa.begin(), region().abscissa.end());
  EXPECT_LT(*low, project(path, x[x.size() - 2]) - 1.0);
  EXPECT_GT(*high, project(path, x.back()) + 1.0);
}

TEST_P(PlacedBalloon, HasItsRegionAllAroundIt) {
  const auto gap = air_mesh::close_region(region().mesh);
  ASSERT_TRUE(gap.has_value());
  const detail::Winding winding(gap->shell);
  for (const Vec3& p : balloon().start.vertices) EXPECT_EQ(winding.at(p), 1);
}

TEST_P(PlacedBalloon, HasAirOverBalloonAndRegionVerticesOnly) {
  ASSERT_EQ(air().vertices.size(), balloon().start.vertices.size() + region().mesh.vertices.size());
  std::set<int> used;
  for (const Tet& t : air().tets) used.insert(t.begin(), t.end());
  EXPECT_EQ(used.size(), air().vertices.size());
  EXPECT_EQ(air().vertices.front(), balloon().start.vertices.front());
  EXPECT_EQ(air().vertices.back(), region().mesh.vertices.back());
}

TEST_P(PlacedBalloon, HasOnlyPositiveAir) {
  for (const Tet& t : air().tets)
    EXPECT_GT(tet_volume(air().vertices[std::size_t(t[0])], air().vertices[std::size_t(t[1])],
                         air().vertices[std::size_t(t[2])], air().vertices[std::size_t(t[3])]),
              0.0);
}

TEST_P(PlacedBalloon, FillsTheGapWithAir) {
  const auto gap = air_mesh::close_region(region().mesh);
  ASSERT_TRUE(gap.has_value());
  const double volume = enclosed_volume(gap->shell) - enclosed_volume(balloon().start);
  EXPECT_NEAR(test::sum_of_tets(air()) / volume, 1.0, 1e-9);
  // Where the vessel turns, the balloon is shorter and that is told.
  EXPECT_THAT(placed().setup.warnings, testing::Each(testing::HasSubstr("turns too far")));
}

std::string vessel_name(const testing::TestParamInfo<const Case& (*)()>& vessel) {
  constexpr const char* kNames[] = {"Stenosed", "Bent", "Forked"};
  return kNames[vessel.index];
}
INSTANTIATE_TEST_SUITE_P(Vessels, PlacedBalloon, testing::Values(&stenosed, &bent, &forked),
                         vessel_name);

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
  const Case tight = place(stenosed_tube(0.75), 18.0, 8.0, 3.0);
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
  const Case turned = place(test::make_arc(1.2, 6.0, 3.0, 0.25), 9.0, 11.0, 2.5);
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
  const Case tight =
      place(test::make_tube(18.0, 0.3, test::stenosis(1.5, 9.0, 4.0, 0.5)), 9.0, 8.0, 3.0);
  EXPECT_LT(tight.setup.balloon.length_mm, 14.0);
  EXPECT_GT(tight.setup.balloon.length_mm, 2.0);
  EXPECT_THAT(tight.setup.warnings, testing::Contains(testing::HasSubstr("shortened")));
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

TEST(PlaceBalloon, GivesTheSameBytesTwice) {
  const Case again = place(stenosed_tube(), 18.0, 8.0, 3.0);
  EXPECT_EQ(again.setup.balloon.start.vertices, stenosed().setup.balloon.start.vertices);
  EXPECT_EQ(again.setup.region.mesh.vertices, stenosed().setup.region.mesh.vertices);
  EXPECT_EQ(again.setup.air.tets.tets, stenosed().setup.air.tets.tets);
}

TEST(TetrahedralizeGap, SurvivesInputThatCrossesItself) {
  TriangleMesh balloon = stenosed().setup.balloon.start;
  const auto gap = air_mesh::close_region(stenosed().setup.region.mesh);
  ASSERT_TRUE(gap.has_value());
  for (Vec3& p : balloon.vertices) p += Vec3{1.0, 0.0, 0.0};  // through the wall of the throat
  std::vector<Vec3> vertices = balloon.vertices;
  vertices.insert(vertices.end(), gap->shell.vertices.begin(), gap->shell.vertices.end());
  std::vector<Triangle> triangles = balloon.triangles;
  for (const Triangle& t : gap->shell.triangles)
    triangles.push_back({t[0] + 522, t[1] + 522, t[2] + 522});
  EXPECT_THROW(air_mesh::tetrahedralize_gap(vertices, triangles, {1.0, 0.0, 18.0}, 20.0),
               InternalError);
}

TEST(TetrahedralizeGap, GivesUpWhenTimeIsUp) {
  const TriangleMesh& balloon = stenosed().setup.balloon.start;
  const auto gap = air_mesh::close_region(stenosed().setup.region.mesh);
  ASSERT_TRUE(gap.has_value());
  EXPECT_THROW(air_mesh::tetrahedralize_gap(gap->shell.vertices, gap->shell.triangles,
                                            balloon.vertices.back(), 1e-6),
               InternalError);
}

// A slack balloon lies where it is pushed: the guidewire's first place may be in the air by then.
TEST(MeshAir, FillsTheGapAroundABalloonThatHasLeftItsGuidewire) {
  const Case placed = place(test::make_tube(36.0, 0.3, [](double) { return 2.0; }), 18.0, 8.0, 4.0);
  TriangleMesh balloon = placed.setup.balloon.start;
  for (Vec3& p : balloon.vertices) p.x += 0.8;
  const TriangleMesh& region = placed.setup.region.mesh;
  const TetMesh air = air_mesh::build_air(balloon, region);
  const auto gap = air_mesh::close_region(region);
  ASSERT_TRUE(gap.has_value());
  EXPECT_NEAR(test::sum_of_tets(air), enclosed_volume(gap->shell) - enclosed_volume(balloon), 1e-6);
}

// The wall next to a rim is held there and pushed along: its folds pass the flat cap.
TEST(MeshAir, EndsBeforeARimWhoseCapTheWallHasPassed) {
  const BalloonSetup& setup = stenosed().setup;
  TriangleMesh wall = setup.region.mesh;
  double end = 0.0;
  for (const Vec3& p : wall.vertices) end = std::max(end, p.z);
  std::size_t pushed = 0;
  double nearest = std::numeric_limits<double>::max();
  for (std::size_t v = 0; v < wall.vertices.size(); ++v) {
    if (setup.region.fixed[v] || end - wall.vertices[v].z > nearest) continue;
    nearest = end - wall.vertices[v].z;
    pushed = v;
  }
  Vec3& p = wall.vertices[pushed];
  p = {0.6 * p.x, 0.6 * p.y, end + 0.3};
  ASSERT_EQ(count_self_intersections(wall), 0U);
  ASSERT_GT(count_self_intersections(air_mesh::close_region(wall)->shell), 0U);
  const std::size_t balloon_count = setup.balloon.start.vertices.size();
  const TetMesh air = air_mesh::build_air(setup.balloon.start, wall);
  ASSERT_FALSE(air.tets.empty());
  std::vector<char> used(air.vertices.size(), 0);
  for (const Tet& t : air.tets)
    for (const int v : t) used[std::size_t(v)] = 1;
  EXPECT_FALSE(used[balloon_count + pushed]);
  std::size_t without_air = 0;
  for (std::size_t v = 0; v < wall.vertices.size(); ++v) {
    EXPECT_EQ(air.vertices[balloon_count + v], wall.vertices[v]);
    without_air += used[balloon_count + v] ? 0 : 1;
  }
  EXPECT_LT(without_air, wall.vertices.size() / 10);
  for (std::size_t v = 0; v < balloon_count; ++v) EXPECT_TRUE(used[v]);
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

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

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

using test::bent;
using test::forked;
using test::place;
using test::PlacedCase;
using test::stenosed;
using test::stenosed_tube;

class PlacedBalloon : public testing::TestWithParam<const PlacedCase& (*)()> {
 protected:
  const PlacedCase& placed() const { return GetParam()(); }
  const Balloon& balloon() const { return placed().setup.balloon; }
  const ContactRegion& region() const { return placed().setup.region; }
  const TetMesh& air() const { return placed().setup.air.tets; }

  /// Three radii, of the balloon or of the lumen around it.
  double reach() const {
    const CenterlinePath& path = placed().vessel.tree.paths[0];
    double widest = 0.5 * balloon().nominal_diameter_mm;
    for (const double s : axis()) widest = std::max(widest, sample(path, s).inscribed_radius);
    return 3.0 * widest;
  }
  double axis_distance(std::size_t v) const {
    double least = 1e300;
    for (const double s : axis())
      least = std::min(least, distance(region().mesh.vertices[v],
                                       sample(placed().vessel.tree.paths[0], s).point));
    return least;
  }

 private:
  std::vector<double> axis() const {
    const CenterlinePath& path = placed().vessel.tree.paths[0];
    const auto& x = balloon().start.vertices;
    const double first = project(path, x[x.size() - 2]), last = project(path, x.back());
    std::vector<double> places;
    for (int i = 0; i <= 200; ++i) places.push_back(first + (last - first) * i / 200.0);
    return places;
  }
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
    EXPECT_EQ(region().fixed[v] != 0, rim.contains(int(v)) || axis_distance(v) > reach());
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
  EXPECT_THAT(placed().setup.warnings,
              testing::Each(testing::HasSubstr("the vessel turns by more than")));
}

std::string vessel_name(const testing::TestParamInfo<const PlacedCase& (*)()>& vessel) {
  constexpr const char* kNames[] = {"Stenosed", "Bent", "Forked"};
  return kNames[vessel.index];
}
INSTANTIATE_TEST_SUITE_P(Vessels, PlacedBalloon, testing::Values(&stenosed, &bent, &forked),
                         vessel_name);

TEST(PlaceBalloon, HoldsTheWallThatIsFarFromIt) {
  // Before a fork at so sharp an angle that the next section clear of it lies far off.
  const PlacedCase sharp =
      place(test::make_fork(1.5, 1.2, 14.0, 30.0, 0.15, 0.3), 8.0, 2.0, 2.0, {.length_mm = 3.0});
  const ContactRegion& region = sharp.setup.region;
  std::set<int> rim;
  for (const auto& loop : boundary_loops(region.mesh)) rim.insert(loop.begin(), loop.end());
  const auto& x = sharp.setup.balloon.start.vertices;
  const CenterlinePath& path = sharp.vessel.tree.paths[0];
  const double last = project(path, x.back());
  int near = 0, far = 0;
  for (std::size_t v = 0; v < region.mesh.vertices.size(); ++v) {
    const double past = region.abscissa[v] - last;  // the balloon's end, along a straight trunk
    if (rim.contains(int(v)) || past < 0.0) continue;
    if (past < 2.0 * 1.5) {
      EXPECT_EQ(region.fixed[v], 0) << "vertex " << v;
      ++near;
    }
    if (past > 3.5 * 1.5) {
      EXPECT_NE(region.fixed[v], 0) << "vertex " << v;
      ++far;
    }
  }
  EXPECT_GT(near, 10);
  EXPECT_GT(far, 10);
}

TEST(PlaceBalloon, GivesTheSameBytesTwice) {
  const PlacedCase again = place(stenosed_tube(), 18.0, 8.0, 3.0);
  EXPECT_EQ(again.setup.balloon.start.vertices, stenosed().setup.balloon.start.vertices);
  EXPECT_EQ(again.setup.region.mesh.vertices, stenosed().setup.region.mesh.vertices);
  EXPECT_EQ(again.setup.air.tets.tets, stenosed().setup.air.tets.tets);
}

}  // namespace
}  // namespace angio::meshing

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

#include "core/triangle_mesh.hpp"
#include "core/units.hpp"
#include "testing/shapes.hpp"

namespace angio {
namespace {

using testing::ElementsAre;
using units::kPi;

/// Two meshes as one, not connected.
TriangleMesh together(TriangleMesh a, const TriangleMesh& b) {
  const int offset = int(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Triangle& t : b.triangles)
    a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

/// Closes every rim with a fan in the order of its loop.
TriangleMesh capped(TriangleMesh mesh) {
  for (const std::vector<int>& loop : boundary_loops(mesh))
    for (std::size_t i = 1; i + 1 < loop.size(); ++i)
      mesh.triangles.push_back({loop[0], loop[i], loop[i + 1]});
  return mesh;
}

TEST(TriangleMesh, BoxHasTheVolumeAndAreaOfABoxWhereverItLies) {
  for (const Vec3& corner : {Vec3{}, Vec3{-100.0, 20.0, 3.0}}) {
    const TriangleMesh box = tests::make_box(corner, {2.0, 3.0, 5.0});
    EXPECT_NEAR(enclosed_volume(box), 30.0, 1e-9);
    EXPECT_NEAR(surface_area(box), 62.0, 1e-9);
  }
}

TEST(TriangleMesh, VolumeIsNegativeWhenNormalsPointInward) {
  TriangleMesh box = tests::make_box({}, {1.0, 1.0, 1.0});
  for (Triangle& t : box.triangles) std::swap(t[1], t[2]);
  EXPECT_NEAR(enclosed_volume(box), -1.0, 1e-12);
}

TEST(TriangleMesh, SphereConvergesToTheClosedFormWithTheSquareOfTheEdge) {
  const double radius = 1.7;
  const auto volume_error = [&](int level) {
    return 4.0 / 3.0 * kPi * std::pow(radius, 3) -
           enclosed_volume(tests::make_sphere({5, 6, 7}, radius, level));
  };
  const auto area_error = [&](int level) {
    return 4.0 * kPi * radius * radius - surface_area(tests::make_sphere({5, 6, 7}, radius, level));
  };
  EXPECT_NEAR(volume_error(4) / volume_error(5), 4.0, 0.1);
  EXPECT_NEAR(area_error(4) / area_error(5), 4.0, 0.1);
  EXPECT_LT(area_error(5) / (4.0 * kPi * radius * radius), 1e-3);
}

TEST(VertexNormals, OfASpherePointAwayFromItsCentre) {
  const Vec3 centre{5, 6, 7};
  const TriangleMesh sphere = tests::make_sphere(centre, 2.0, 4);
  const std::vector<Vec3> normals = vertex_normals(sphere);
  for (std::size_t v = 0; v < normals.size(); ++v)
    EXPECT_GT(dot(normals[v], normalized(sphere.vertices[v] - centre)), 0.999);
}

TEST(VertexNormals, AreZeroAtAnIsolatedVertex) {
  TriangleMesh mesh = tests::make_box({}, {1, 1, 1});
  mesh.vertices.push_back({9, 9, 9});
  EXPECT_EQ(vertex_normals(mesh).back(), (Vec3{}));
}

TEST(VertexAreas, SumToTheSurfaceArea) {
  const TriangleMesh torus = tests::make_torus(3.0, 1.0, 24, 12);
  const std::vector<double> areas = vertex_areas(torus);
  EXPECT_NEAR(std::accumulate(areas.begin(), areas.end(), 0.0), surface_area(torus), 1e-10);
}

TEST(UniqueEdges, OfAClosedSurfaceAreThreeHalvesOfItsTriangles) {
  const TriangleMesh torus = tests::make_torus(3.0, 1.0, 24, 12);
  const auto edges = unique_edges(torus);
  EXPECT_EQ(2 * edges.size(), 3 * torus.triangles.size());
  EXPECT_TRUE(std::is_sorted(edges.begin(), edges.end()));
  for (const auto& [a, b] : edges) EXPECT_LT(a, b);
}

TEST(VertexNeighbors, AreMutualAndAscending) {
  const auto neighbors = vertex_neighbors(tests::make_sphere({}, 1.0, 2));
  for (std::size_t v = 0; v < neighbors.size(); ++v) {
    EXPECT_TRUE(std::is_sorted(neighbors[v].begin(), neighbors[v].end()));
    for (const int w : neighbors[v])
      EXPECT_THAT(neighbors[std::size_t(w)], testing::Contains(int(v)));
  }
}

TEST(TriangleNeighbors, OfAClosedSurfaceShareTheirSideTheOtherWayRound) {
  const TriangleMesh torus = tests::make_torus(3.0, 1.0, 24, 12);
  const auto neighbors = triangle_neighbors(torus);
  ASSERT_EQ(neighbors.size(), torus.triangles.size());
  for (std::size_t t = 0; t < neighbors.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_GE(neighbors[t][c], 0);
      const Triangle& other = torus.triangles[std::size_t(neighbors[t][c])];
      const auto begin = std::find(other.begin(), other.end(), torus.triangles[t][(c + 1) % 3]);
      ASSERT_NE(begin, other.end());
      const auto side = std::size_t(begin - other.begin());
      EXPECT_EQ(other[(side + 1) % 3], torus.triangles[t][c]);
      EXPECT_EQ(neighbors[std::size_t(neighbors[t][c])][side], int(t));
    }
}

TEST(TriangleNeighbors, AreNoneAtARimAndWhereThreeMeet) {
  const TriangleMesh tube = tests::make_tube(1.0, 4.0, 5, 12);
  int none = 0;
  for (const auto& around : triangle_neighbors(tube))
    none += int(std::count(around.begin(), around.end(), -1));
  EXPECT_EQ(none, surface_topology(tube).boundary_edge_count);
  const TriangleMesh fan{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}},
                         {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}};
  for (const auto& around : triangle_neighbors(fan)) EXPECT_THAT(around, ElementsAre(-1, -1, -1));
}

TEST(SurfaceTopology, TellsSphereTorusAndTubeApartByTheEulerNumber) {
  const SurfaceTopology sphere = surface_topology(tests::make_sphere({}, 1.0, 3));
  const SurfaceTopology torus = surface_topology(tests::make_torus(3.0, 1.0, 20, 10));
  const SurfaceTopology tube = surface_topology(tests::make_tube(1.0, 4.0, 9, 12));
  EXPECT_EQ(sphere.euler_number, 2);
  EXPECT_EQ(torus.euler_number, 0);
  EXPECT_EQ(tube.euler_number, 0);
  EXPECT_TRUE(sphere.is_closed());
  EXPECT_TRUE(torus.is_closed());
  EXPECT_FALSE(tube.is_closed());
  EXPECT_EQ(tube.boundary_edge_count, 2 * 12);
}

TEST(SurfaceTopology, CountsPiecesAndLeavesOutIsolatedVertices) {
  TriangleMesh mesh =
      together(tests::make_box({}, {1, 1, 1}), tests::make_sphere({9, 9, 9}, 1.0, 1));
  mesh.vertices.push_back({50, 50, 50});
  const SurfaceTopology topology = surface_topology(mesh);
  EXPECT_EQ(topology.component_count, 2);
  EXPECT_EQ(topology.euler_number, 4);
  EXPECT_TRUE(topology.is_closed());
}

TEST(SurfaceTopology, CallsAFlippedTriangleNonmanifoldAtItsThreeEdges) {
  TriangleMesh sphere = tests::make_sphere({}, 1.0, 2);
  std::swap(sphere.triangles[5][0], sphere.triangles[5][1]);
  const SurfaceTopology topology = surface_topology(sphere);
  EXPECT_EQ(topology.nonmanifold_edge_count, 3);
  EXPECT_EQ(topology.boundary_edge_count, 0);
}

TEST(SurfaceTopology, CallsAnEdgeOfThreeTrianglesNonmanifold) {
  TriangleMesh box = tests::make_box({}, {1, 1, 1});
  box.vertices.push_back({-1, -1, -1});
  box.triangles.push_back({0, 1, 8});  // a fin on the edge 0-1
  EXPECT_EQ(surface_topology(box).nonmanifold_edge_count, 1);
}

TEST(BoundaryLoops, OfAClosedSurfaceAreNone) {
  EXPECT_TRUE(boundary_loops(tests::make_torus(3.0, 1.0, 20, 10)).empty());
}

TEST(BoundaryLoops, OfATubeAreItsTwoRimsAndCapItWithOutwardNormals) {
  const double radius = 1.5, length = 4.0;
  const int corners = 12;
  const TriangleMesh tube = tests::make_tube(radius, length, 9, corners);
  EXPECT_EQ(boundary_loops(tube).size(), 2u);
  for (const auto& loop : boundary_loops(tube)) EXPECT_EQ(loop.size(), std::size_t(corners));

  const TriangleMesh prism = capped(tube);
  EXPECT_TRUE(surface_topology(prism).is_closed());
  EXPECT_EQ(surface_topology(prism).euler_number, 2);
  const double polygon_area = 0.5 * corners * radius * radius * std::sin(2.0 * kPi / corners);
  EXPECT_NEAR(enclosed_volume(prism), polygon_area * length, 1e-12);
}

TEST(BoundaryLoops, ComeTheLongestFirst) {
  TriangleMesh cone = tests::make_tube(1.0, 4.0, 5, 16);
  for (Vec3& v : cone.vertices) {  // narrow at z = 0, wide at z = 4
    v.x *= 0.5 + 0.5 * v.z;
    v.y *= 0.5 + 0.5 * v.z;
  }
  const auto loops = boundary_loops(cone);
  ASSERT_EQ(loops.size(), 2u);
  EXPECT_DOUBLE_EQ(cone.vertices[std::size_t(loops[0][0])].z, 4.0);
  EXPECT_DOUBLE_EQ(cone.vertices[std::size_t(loops[1][0])].z, 0.0);
}

TEST(BoundaryLoops, ThatShareAVertexKeepEveryEdge) {
  // A grid of squares with two holes that meet in vertex 12 only.
  TriangleMesh sheet;
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 5; ++x) sheet.vertices.push_back({double(x), double(y), 0.0});
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      if ((x == 1 && y == 1) || (x == 2 && y == 2)) continue;
      const int v = 5 * y + x;
      sheet.triangles.push_back({v, v + 1, v + 6});
      sheet.triangles.push_back({v, v + 6, v + 5});
    }
  const auto loops = boundary_loops(sheet);
  ASSERT_EQ(loops.size(), 3U);
  std::size_t edge_count = 0;
  for (const auto& loop : loops) {
    edge_count += loop.size();
    EXPECT_EQ(std::set<int>(loop.begin(), loop.end()).size(), loop.size());
  }
  EXPECT_EQ(int(edge_count), surface_topology(sheet).boundary_edge_count);
  EXPECT_EQ(loops[1].size(), 4U);
  EXPECT_EQ(loops[2].size(), 4U);
}

TEST(BoundaryLoops, OfTrianglesThatTouchInACornerAreOneForEach) {
  TriangleMesh bow;
  bow.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  bow.triangles = {{0, 1, 2}, {0, 3, 4}};
  const auto loops = boundary_loops(bow);
  ASSERT_EQ(loops.size(), 2U);
  EXPECT_EQ(loops[0].size(), 3U);
  EXPECT_EQ(loops[1].size(), 3U);
}

TEST(BoundaryLoops, OfOneTriangleRunAgainstIt) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  ASSERT_EQ(boundary_loops(mesh).size(), 1u);
  EXPECT_THAT(boundary_loops(mesh)[0], ElementsAre(0, 2, 1));
}

}  // namespace
}  // namespace angio

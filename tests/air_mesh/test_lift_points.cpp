// A point that TetGen put on a surface goes into the gap; the surface has its own triangles again.
#include <gtest/gtest.h>

#include <algorithm>

#include "air_mesh/build/lift_points.hpp"
#include "air_mesh/build/tet_shape.hpp"

namespace angio::air_mesh {
namespace {

double volume_of(const TetMesh& mesh) {
  double sum = 0.0;
  for (const Tet& t : mesh.tets)
    sum += tet_volume(mesh.vertices[std::size_t(t[0])], mesh.vertices[std::size_t(t[1])],
                      mesh.vertices[std::size_t(t[2])], mesh.vertices[std::size_t(t[3])]);
  return sum;
}

double least_volume(const TetMesh& mesh) {
  double least = 1e9;
  for (const Tet& t : mesh.tets)
    least = std::min(
        least, tet_volume(mesh.vertices[std::size_t(t[0])], mesh.vertices[std::size_t(t[1])],
                          mesh.vertices[std::size_t(t[2])], mesh.vertices[std::size_t(t[3])]));
  return least;
}

// The tets from a point to all faces of an octahedron but those in whose planes it lies.
TetMesh octahedron_with(const Vec3& point) {
  TetMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, point};
  for (const int a : {0, 1})
    for (const int b : {2, 3})
      for (const int c : {4, 5}) {
        Tet t{a, b, c, 6};
        const double volume =
            tet_volume(mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)],
                       mesh.vertices[std::size_t(c)], point);
        if (std::abs(volume) < 1e-12) continue;
        if (volume < 0.0) std::swap(t[0], t[1]);
        mesh.tets.push_back(t);
      }
  return mesh;
}

void expect_lifted(TetMesh mesh) {
  ASSERT_TRUE(lift_off_surfaces(mesh, 6));
  EXPECT_EQ(mesh.tets.size(), 8U);  // one over every face of the octahedron
  EXPECT_GT(least_volume(mesh), 0.01);
  EXPECT_NEAR(volume_of(mesh), 4.0 / 3.0, 1e-12);
}

TEST(LiftOffSurfaces, APointOnATriangleGoesIntoTheGap) {
  expect_lifted(octahedron_with({0.2, 0.3, 0.5}));
}

TEST(LiftOffSurfaces, APointOnAnEdgeGoesIntoTheGap) {
  expect_lifted(octahedron_with({0.37, 0.63, 0.0}));
}

TEST(LiftOffSurfaces, TwoPointsOnEdgesOfOneTriangleGoIntoTheGap) {
  // The first splits the edge (0, 2), the second (2, 4).
  TetMesh mesh = octahedron_with({0.5, 0.5, 0.0});
  const int second = int(mesh.vertices.size());
  mesh.vertices.push_back({0.0, 0.25, 0.75});
  std::vector<Tet> split;
  for (const Tet& t : mesh.tets) {
    if (std::find(t.begin(), t.end(), 2) == t.end() ||
        std::find(t.begin(), t.end(), 4) == t.end()) {
      split.push_back(t);
      continue;
    }
    for (const int end : {2, 4}) {
      Tet part = t;
      std::replace(part.begin(), part.end(), end, second);
      split.push_back(part);
    }
  }
  mesh.tets = split;
  const double volume = volume_of(mesh);
  ASSERT_TRUE(lift_off_surfaces(mesh, 6));
  EXPECT_GT(least_volume(mesh), 1e-3);
  EXPECT_NEAR(volume_of(mesh), volume, 1e-12);
}

TEST(LiftOffSurfaces, PointsInTheGapStay) {
  const TetMesh before = octahedron_with({0.1, 0.2, -0.1});
  TetMesh mesh = before;
  ASSERT_TRUE(lift_off_surfaces(mesh, 6));
  EXPECT_EQ(mesh.tets, before.tets);
  EXPECT_EQ(mesh.vertices[6], before.vertices[6]);
}

}  // namespace
}  // namespace angio::air_mesh

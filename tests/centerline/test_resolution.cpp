#include <gtest/gtest.h>

#include "centerline/resolution.hpp"

namespace angio::centerline {
namespace {

/// Equilateral triangles in the plane z = 0, of edge 0.5 for x < 10 and 2 beyond.
TriangleMesh two_meshes() {
  TriangleMesh mesh;
  const auto add = [&](double x, double y, double edge) {
    const int first = int(mesh.vertices.size());
    for (const Vec3& corner : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0.5, 0.8660254037844386, 0}})
      mesh.vertices.push_back(Vec3{x, y, 0.0} + edge * corner);
    mesh.triangles.push_back({first, first + 1, first + 2});
  };
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) add(0.5 * i, 0.5 * j, 0.5);
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j) add(10.0 + 2.0 * i, 2.0 * j, 2.0);
  return mesh;
}

TEST(Resolution, OfASurfaceIsTheEdgeAround) {
  const TriangleMesh mesh = two_meshes();
  EXPECT_NEAR(edge_around(mesh, {4.0, 4.0, 0.0}, 2.0), 0.5, 1e-9);
  EXPECT_NEAR(edge_around(mesh, {16.0, 4.0, 0.0}, 2.0), 2.0, 1e-9);
  EXPECT_NEAR(edge_around(mesh, {4.0, 4.0, 9.0}, 2.0), 0.5, 1e-9);  // the nearest one's
}

TEST(Resolution, ForTheWholeTreeNoPlaceIsChosen) {
  LesionOptions options;
  options.centerline = 3;
  options.abscissa_mm = 4.0;
  options.voxel_mm = 0.3;
  const LesionOptions all = whole_tree(options);
  EXPECT_EQ(all.centerline, -1);
  EXPECT_EQ(all.abscissa_mm, -1.0);
  EXPECT_EQ(all.voxel_mm, 0.3);
}

}  // namespace
}  // namespace angio::centerline

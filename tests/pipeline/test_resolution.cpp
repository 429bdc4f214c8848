#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/case/resolution.hpp"

namespace angio::pipeline {
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

TEST(Resolution, OfASurfaceIsTwoOfTheEdgesAround) {
  const TriangleMesh mesh = two_meshes();
  EXPECT_NEAR(least_diameter_shown(mesh, {4.0, 4.0, 0.0}, 2.0), 1.0, 1e-9);
  EXPECT_NEAR(least_diameter_shown(mesh, {16.0, 4.0, 0.0}, 2.0), 4.0, 1e-9);
  EXPECT_NEAR(least_diameter_shown(mesh, {4.0, 4.0, 9.0}, 2.0), 1.0, 1e-9);  // the nearest one's
}

TEST(Resolution, OfALabelMapIsHalfThatOfAScan) {
  VolumeGeometry geometry;
  geometry.size = {12, 12, 12};
  geometry.spacing = {0.5, 0.5, 0.8};
  Volume<float> scan(geometry, 0.0F), labels(geometry, 0.0F);
  for (std::size_t i = 0; i < scan.values.size(); ++i) {
    scan.values[i] = float(i % 97) + 0.25F * float(i % 5);
    labels.values[i] = i % 3 == 0 ? 1.0F : 0.0F;
  }
  EXPECT_DOUBLE_EQ(resolution_of(scan).longest_mm, 0.8);
  EXPECT_DOUBLE_EQ(resolution_of(scan).mean_mm, std::cbrt(0.5 * 0.5 * 0.8));
  EXPECT_DOUBLE_EQ(resolution_of(labels).longest_mm, 1.6);
  EXPECT_DOUBLE_EQ(resolution_of(labels).mean_mm, 2.0 * std::cbrt(0.5 * 0.5 * 0.8));
}

TEST(Resolution, ForTheWholeTreeNoPlaceIsChosen) {
  centerline::LesionOptions options;
  options.centerline = 3;
  options.abscissa_mm = 4.0;
  options.voxel_mm = 0.3;
  const centerline::LesionOptions all = whole_tree(options);
  EXPECT_EQ(all.centerline, -1);
  EXPECT_EQ(all.abscissa_mm, -1.0);
  EXPECT_EQ(all.voxel_mm, 0.3);
}

}  // namespace
}  // namespace angio::pipeline

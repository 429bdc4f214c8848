#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "meshing/detail/surface_target.hpp"
#include "meshing/meshing.hpp"
#include "testing/meshing/analytic_vessels.hpp"
#include "tests/meshing/cap_centre.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

/// A tube along z as rings of 24 vertices, open or closed by fans.
TriangleMesh tube_surface(double radius, double length, bool closed) {
  constexpr int kSides = 24;
  const int rings = int(length / 0.4) + 1;
  TriangleMesh mesh;
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k < kSides; ++k) {
      const double a = 2.0 * pi * k / kSides;
      mesh.vertices.push_back(
          {radius * std::cos(a), radius * std::sin(a), length * i / (rings - 1)});
    }
  for (int i = 0; i + 1 < rings; ++i)
    for (int k = 0; k < kSides; ++k) {
      const int a = i * kSides + k, b = i * kSides + (k + 1) % kSides;
      mesh.triangles.push_back({a, b, b + kSides});
      mesh.triangles.push_back({a, b + kSides, a + kSides});
    }
  if (!closed) return mesh;
  const int first = int(mesh.vertices.size());
  mesh.vertices.push_back({0.0, 0.0, 0.0});
  mesh.vertices.push_back({0.0, 0.0, length});
  const int top = (rings - 1) * kSides;
  for (int k = 0; k < kSides; ++k) {
    mesh.triangles.push_back({first, (k + 1) % kSides, k});
    mesh.triangles.push_back({first + 1, top + k, top + (k + 1) % kSides});
  }
  return mesh;
}

CenterlineTree tube_tree() {
  return test::make_tube(20.0, 0.5, [](double) { return 1.5; }).tree;
}

/// Area of the 24-gon of the surface over that of the circle.
const double kPolygonArea = 12.0 * std::sin(2.0 * pi / 24.0) * 1.5 * 1.5;

void expect_good_tube(const TriangleMesh& surface, double least_length) {
  const LumenMesh lumen = mesh_lumen(surface, tube_tree(), {});
  EXPECT_TRUE(lumen.watertight);
  EXPECT_EQ(lumen.self_intersection_count, 0);
  EXPECT_GT(lumen.min_angle_degrees, 20.0);
  ASSERT_EQ(boundary_loops(lumen.open).size(), 2U);
  const double length = distance(cap_centre(lumen, 1), cap_centre(lumen, 2));
  EXPECT_GT(length, least_length);
  EXPECT_NEAR(enclosed_volume(lumen.capped) / (kPolygonArea * length), 1.0, 0.01);
}

TEST(SurfaceTarget, SaysWhatTheLumenWasFoundIn) {
  EXPECT_EQ(detail::MeshTarget(tube_surface(1.5, 20.0, false)).source(), "surface");
  EXPECT_EQ(detail::LevelSetTarget(Volume<float>{}).source(), "image");
}

TEST(LumenFromSurface, OpensAClosedTube) { expect_good_tube(tube_surface(1.5, 20.0, true), 17.0); }

TEST(LumenFromSurface, KeepsTheRimsOfAnOpenTube) {
  expect_good_tube(tube_surface(1.5, 20.0, false), 20.0 - 1e-9);
}

// An outlet that narrows to less than half before its rim is one all the same: the line ends there.
TEST(LumenFromSurface, KeepsARimThatTheLineEndsInTheMiddleOf) {
  TriangleMesh surface = tube_surface(1.5, 20.0, false);
  for (Vec3& p : surface.vertices) {
    const double narrowed = 1.0 - 0.6 * std::clamp((p.z - 17.0) / 3.0, 0.0, 1.0);
    p.x *= narrowed;
    p.y *= narrowed;
  }
  const LumenMesh lumen = mesh_lumen(surface, tube_tree(), {});
  for (const std::string& warning : lumen.warnings)
    EXPECT_EQ(warning.find("no line ends"), std::string::npos) << warning;
  EXPECT_EQ(boundary_loops(lumen.open).size(), 2U);
}

TEST(LumenFromSurface, TurnsAnInsideOutTube) {
  TriangleMesh surface = tube_surface(1.5, 20.0, true);
  for (Triangle& t : surface.triangles) std::swap(t[0], t[1]);
  expect_good_tube(surface, 17.0);
}

TEST(LumenFromSurface, MergesATriangleSoupAndFillsItsHole) {
  const TriangleMesh whole = tube_surface(1.5, 20.0, true);
  TriangleMesh soup;
  for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
    if (t == whole.triangles.size() / 2) continue;
    const int first = int(soup.vertices.size());
    for (const int v : whole.triangles[t]) soup.vertices.push_back(whole.vertices[std::size_t(v)]);
    soup.triangles.push_back(t % 3 == 0 ? Triangle{first, first + 2, first + 1}
                                        : Triangle{first, first + 1, first + 2});
  }
  expect_good_tube(soup, 17.0);
}

TEST(LumenFromSurface, WithoutTrianglesIsAnInputError) {
  EXPECT_THROW(mesh_lumen(TriangleMesh{}, tube_tree(), {}), InputError);
}

}  // namespace
}  // namespace angio::meshing

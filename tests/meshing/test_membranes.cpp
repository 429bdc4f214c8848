#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "air_mesh/build/surface_crossings.hpp"
#include "meshing/detail/crossings.hpp"
#include "meshing/detail/edge_lengths.hpp"
#include "meshing/detail/remesh.hpp"
#include "meshing/detail/surface_target.hpp"
#include "testing/shapes.hpp"

namespace angio::meshing::detail {
namespace {

constexpr double kRing = 5.0, kTube = 1.0;  // of a torus around z [mm]

/// How far a place is from the torus [mm]; negative inside.
double off(const Vec3& p) { return std::hypot(std::hypot(p.x, p.y) - kRing, p.z) - kTube; }

SurfaceDraft draft_of(const TriangleMesh& mesh) {
  SurfaceDraft draft;
  draft.mesh = mesh;
  draft.edge_length = mean_edge_lengths(mesh);
  draft.rim.assign(mesh.vertices.size(), -1);
  draft.membrane.assign(mesh.vertices.size(), 0);
  return draft;
}

/// Presses the surface around a place in, as a membrane across it lies. Of the vertices at its edge
/// the mark is lost, as it is where they were collapsed into others.
void dent(SurfaceDraft& draft, const Vec3& place, double depth) {
  constexpr double kReach = 0.7, kMarked = 0.5;
  const std::vector<Vec3> normals = vertex_normals(draft.mesh);
  for (std::size_t v = 0; v < normals.size(); ++v) {
    Vec3& at = draft.mesh.vertices[v];
    const double away = distance(at, place) / kReach;
    if (away >= 1.0) continue;
    draft.membrane[v] = away < kMarked ? 1 : 0;
    at -= depth * (1.0 - away * away) * normals[v];
  }
}

TEST(BringMembranesBack, TakesADentedThroatToItsTargetAndNothingElse) {
  const TriangleMesh torus = tests::make_torus(kRing, kTube, 120, 24);
  const MeshTarget target(torus);
  SurfaceDraft draft = draft_of(torus);
  const std::vector<Vec3> places = {{kRing + kTube, 0.0, 0.0}, {0.0, kRing - kTube, 0.0}};
  for (const Vec3& place : places) dent(draft, place, 0.15);
  ASSERT_LT(off(*std::min_element(draft.mesh.vertices.begin(), draft.mesh.vertices.end(),
                                  [](const Vec3& a, const Vec3& b) { return off(a) < off(b); })),
            -0.14);
  bring_membranes_back(draft, target);
  for (const Vec3& p : draft.mesh.vertices) EXPECT_NEAR(off(p), 0.0, 0.012);  // a chord's height
  EXPECT_EQ(std::count(draft.membrane.begin(), draft.membrane.end(), 1), 0);
  EXPECT_TRUE(air_mesh::self_intersections(draft.mesh).empty());
  for (const Vec3& p : torus.vertices) {
    const bool is_far = std::all_of(places.begin(), places.end(),
                                    [&](const Vec3& q) { return distance(p, q) > 2.5; });
    if (!is_far) continue;
    EXPECT_TRUE(std::any_of(draft.mesh.vertices.begin(), draft.mesh.vertices.end(),
                            [&](const Vec3& v) { return v == p; }));
  }
}

// A sheet over the mouth of a hollow that is deeper than a membrane may go.
TEST(BringMembranesBack, LeavesAMembraneThatTheTargetIsFarFrom) {
  constexpr double kWide = 3.0, kDeep = 0.9;  // to each side, of the hollow [mm]
  const TriangleMesh torus = tests::make_torus(2.0 * kRing, 2.0 * kTube, 240, 48);
  TriangleMesh hollow = torus;
  const Vec3 place{2.0 * (kRing + kTube), 0.0, 0.0};
  for (Vec3& p : hollow.vertices) {
    const double away = distance(p, place) / kWide;
    if (away < 1.0) p.x -= kDeep * (1.0 - away * away) * (1.0 - away * away);
  }
  const MeshTarget target(hollow);
  SurfaceDraft draft = draft_of(torus);
  for (std::size_t v = 0; v < torus.vertices.size(); ++v)
    draft.membrane[v] = distance(torus.vertices[v], place) < kWide ? 1 : 0;
  bring_membranes_back(draft, target);
  EXPECT_TRUE(draft.mesh.vertices == torus.vertices);
  EXPECT_GT(std::count(draft.membrane.begin(), draft.membrane.end(), 1), 0);
}

// Two triangles are missing: one beside a rim, and one on its own.
TEST(CloseOpenings, LeavesRimsOpenAlone) {
  const TriangleMesh torus = tests::make_torus(kRing, kTube, 60, 16);
  SurfaceDraft draft = draft_of(torus);
  std::vector<Triangle>& triangles = draft.mesh.triangles;
  const Triangle rim = triangles.front();
  triangles.erase(triangles.begin() + std::ptrdiff_t(triangles.size() / 2));
  triangles.erase(triangles.begin());
  EXPECT_EQ(boundary_loops(draft.mesh).size(), 2U);
  for (const int v : rim) draft.rim[std::size_t(v)] = 0;
  draft.rim_planes.push_back({torus.vertices[std::size_t(rim[0])], {0.0, 0.0, 1.0}});
  EXPECT_EQ(close_openings(draft), 1);
  const auto loops = boundary_loops(draft.mesh);
  ASSERT_EQ(loops.size(), 1U);
  for (const int v : loops.front()) EXPECT_EQ(draft.rim[std::size_t(v)], 0);
  EXPECT_EQ(close_openings(draft), 0);
}

}  // namespace
}  // namespace angio::meshing::detail

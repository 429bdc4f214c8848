#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "air_mesh/build/build_air.hpp"
#include "air_mesh/build/gap_boundary.hpp"
#include "air_mesh/build/gap_mesh.hpp"
#include "core/error.hpp"
#include "testing/meshing/placed_balloon.hpp"
#include "testing/shapes.hpp"

namespace angio::meshing {
namespace {

using test::place;
using test::PlacedCase;
using test::stenosed;

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
  const PlacedCase placed =
      place(test::make_tube(36.0, 0.3, [](double) { return 2.0; }), 18.0, 8.0, 4.0);
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

}  // namespace
}  // namespace angio::meshing

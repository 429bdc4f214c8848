#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "air_mesh/adaptive_air.hpp"
#include "air_mesh/build/build_air.hpp"
#include "air_mesh/tet_topology.hpp"
#include "core/units.hpp"
#include "testing/shapes.hpp"

namespace angio::air_mesh {
namespace {

// A prism whose upper triangle is turned by 30 degrees, so that its sides bend inwards along their
// diagonals: no tetrahedra over its six corners fill it (Schoenhardt 1928).
TEST(Hollow, ThatNoTetsOverItsCornersFillGetsPoints) {
  std::vector<Vec3> x;
  for (const double z : {0.0, 1.0})
    for (int k = 0; k < 3; ++k) {
      const double angle = (120.0 * k - 30.0 * z) * units::kPi / 180.0;
      x.push_back({std::cos(angle), std::sin(angle), z});
    }
  std::vector<Triangle> faces{{0, 2, 1}, {3, 4, 5}};
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    faces.push_back({k, next, 3 + k});
    faces.push_back({next, 3 + next, 3 + k});
  }
  const TetMesh mesh = mesh_hollow(x, faces);
  ASSERT_FALSE(mesh.tets.empty());
  EXPECT_GT(mesh.vertices.size(), x.size());
  double volume = 0.0;
  for (const Tet& t : mesh.tets) {
    const auto at = [&](int i) { return mesh.vertices[std::size_t(t[std::size_t(i)])]; };
    EXPECT_GT(tet_volume(at(0), at(1), at(2), at(3)), 0.0);
    volume += tet_volume(at(0), at(1), at(2), at(3));
  }
  TriangleMesh outside;
  outside.vertices = x;
  outside.triangles = faces;
  EXPECT_NEAR(volume, std::abs(enclosed_volume(outside)), 1e-9);
  const auto ascending = [](Triangle f) {
    std::sort(f.begin(), f.end());
    return f;
  };
  std::vector<Triangle> given, found;
  for (const Triangle& f : faces) given.push_back(ascending(f));
  const TetTopology topology(mesh.tets);
  for (const TetFace& f : topology.boundary())
    found.push_back(ascending(topology.face(f.tet, f.corner)));
  std::sort(given.begin(), given.end());
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, given);
}

// A ball in a tube leaves it by the middle of the cap over its end.
TEST(AdaptiveAir, EndsBeforeACapThatTheBalloonBulgesThrough) {
  const TriangleMesh ball = angio::tests::make_sphere({0.0, 0.0, 4.0}, 0.8, 2);
  TriangleMesh tube = angio::tests::make_tube(1.5, 8.0, 13, 24);
  const TetMesh mesh = build_air(ball, tube);
  ASSERT_FALSE(mesh.tets.empty());
  std::vector<Triangle> surfaces = ball.triangles;
  const int count = int(ball.vertices.size());
  for (const Triangle& t : tube.triangles)
    surfaces.push_back({t[0] + count, t[1] + count, t[2] + count});
  std::vector<Vec3> x = mesh.vertices;  // with those of the caps, which rest
  AdaptiveAir air(mesh.tets, x, surfaces, {{}, mesh_hollow});
  ASSERT_TRUE(air.is_whole());
  for (int frame = 0; frame < 40; ++frame) {
    for (int v = 0; v < count; ++v) x[std::size_t(v)].z += 0.1;
    air.follow(x);
    EXPECT_TRUE(air.is_whole()) << frame;
    EXPECT_EQ(air.take_report().inverted_count, 0) << frame;
  }
}

}  // namespace
}  // namespace angio::air_mesh

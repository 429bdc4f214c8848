#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "air_mesh/build/build_air.hpp"
#include "air_mesh/tet_topology.hpp"
#include "core/units.hpp"

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

}  // namespace
}  // namespace angio::air_mesh

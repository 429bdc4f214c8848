#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "air_mesh/build/distances_ahead.hpp"
#include "meshing/detail/outward_cone.hpp"
#include "testing/shapes.hpp"

namespace angio::meshing {
namespace {

TEST(MostNormal, IsTheAxisOfTheNarrowestCone) {
  const std::vector<Vec3> corner{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const detail::Outward out = detail::most_normal(corner);
  EXPECT_NEAR(out.rise, 1.0 / std::sqrt(3.0), 1e-12);
  // One that lies within the cone changes nothing, nor does one twice.
  const detail::Outward same =
      detail::most_normal({corner[0], corner[1], normalized(Vec3{1, 1, 1}), corner[2], corner[2]});
  EXPECT_LT(distance(same.direction, out.direction), 1e-12);
  EXPECT_LE(detail::most_normal({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}}).rise, 1e-12);
}

TEST(Risen, TurnsAWayNoFurtherThanItNeeds) {
  const std::vector<Vec3> plane{{0, 0, 1}};
  const detail::Outward out = detail::most_normal(plane);
  const Vec3 steep{0.0, 1.0, 2.0}, flat{2.0, 0.0, 0.0};
  EXPECT_EQ(detail::risen(steep, plane, out, 0.3), steep);
  const Vec3 turned = detail::risen(flat, plane, out, 0.3);
  EXPECT_NEAR(norm(turned), 2.0, 1e-9);
  EXPECT_NEAR(turned.z / 2.0, 0.3, 1e-4);
  EXPECT_GT(turned.x, 0.0);
}

TEST(DistancesAhead, AreThoseToTheOppositeWall) {
  const TriangleMesh tube = tests::make_tube(1.5, 10.0, 60, 40);
  std::vector<Vec3> inward = vertex_normals(tube);
  for (Vec3& n : inward) n = -1.0 * n;
  const std::vector<double> reach(tube.vertices.size(), 5.0);
  const auto inside = air_mesh::distances_ahead(tube, inward, reach, air_mesh::Side::inside);
  const auto outside = air_mesh::distances_ahead(tube, inward, reach, air_mesh::Side::outside);
  for (std::size_t v = 0; v < inside.size(); ++v) {
    if (std::abs(tube.vertices[v].z - 5.0) > 4.0) continue;
    EXPECT_NEAR(inside[v], 3.0, 0.02);
    EXPECT_TRUE(std::isinf(outside[v]));
  }
}

}  // namespace
}  // namespace angio::meshing

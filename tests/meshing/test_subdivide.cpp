#include <gtest/gtest.h>

#include "meshing/subdivide.hpp"

namespace angio::meshing {
namespace {

TEST(Subdivide, KeepsAreaVolumeAndTopology) {
  const TriangleMesh tetrahedron{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                 {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  const TriangleMesh fine = subdivide(tetrahedron);
  EXPECT_EQ(fine.triangles.size(), 16u);
  EXPECT_EQ(fine.vertices.size(), 10u);
  EXPECT_TRUE(surface_topology(fine).is_closed());
  EXPECT_EQ(surface_topology(fine).euler_number, 2);
  EXPECT_NEAR(surface_area(fine), surface_area(tetrahedron), 1e-14);
  EXPECT_NEAR(enclosed_volume(fine), enclosed_volume(tetrahedron), 1e-15);
}

}  // namespace
}  // namespace angio::meshing

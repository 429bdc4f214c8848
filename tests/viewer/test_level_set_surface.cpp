#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "viewer/level_set_surface.hpp"

namespace angio::viewer {
namespace {

constexpr double kSpacing = 0.5, kRadius = 4.0;  // mm

/// Distance from a sphere around a place, on a grid that is turned by 90 degrees about z.
Volume<float> sphere_at(const Vec3& middle) {
  VolumeGeometry grid;
  grid.size = {24, 26, 28};
  grid.spacing = {kSpacing, kSpacing, kSpacing};
  grid.direction(0, 0) = grid.direction(1, 1) = 0.0;
  grid.direction(0, 1) = -1.0;
  grid.direction(1, 0) = 1.0;
  grid.origin = {20.0, -30.0, 10.0};
  Volume<float> level_set(grid);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        level_set.at(i, j, k) = float(
            distance(grid.lps_from_index({double(i), double(j), double(k)}), middle) - kRadius);
  return level_set;
}

TEST(ZeroSurface, OfASphereIsClosedAndOnTheSphere) {
  const Vec3 middle{13.8, -24.1, 16.7};
  const TriangleMesh surface = zero_surface(sphere_at(middle));
  const SurfaceTopology topology = surface_topology(surface);
  EXPECT_TRUE(topology.is_closed());
  EXPECT_EQ(topology.euler_number, 2);
  EXPECT_GT(enclosed_volume(surface), 0.0);
  // Along an edge of the grid the distance is no straight line, but it bends by 1 / R at most.
  for (const Vec3& p : surface.vertices)
    EXPECT_NEAR(distance(p, middle), kRadius, kSpacing * kSpacing / (8.0 * kRadius) + 1e-5);
}

TEST(ZeroSurface, IsOpenWhereItLeavesTheVolumeAndEmptyWhereThereIsNone) {
  EXPECT_EQ(boundary_loops(zero_surface(sphere_at({13.8, -24.1, 10.0}))).size(), 1U);
  EXPECT_TRUE(zero_surface(sphere_at({100.0, 0.0, 0.0})).triangles.empty());
}

}  // namespace
}  // namespace angio::viewer

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "centerline/detail/lattice.hpp"
#include "centerline/resolution.hpp"
#include "core/units.hpp"
#include "core/volume.hpp"
#include "meshing/detail/isosurface.hpp"
#include "testing/shapes.hpp"

namespace angio::centerline::detail {
namespace {

using namespace angio::tests;

const Vec3 kSpacing{0.4, 0.4, 0.6};  // [mm]

/// Negative inside a helix of radius 8 mm and of 1.5 mm of lumen radius.
double distance_to_helix(const Vec3& x) {
  double nearest = 1e30;
  for (int n = 0; n < 400; ++n) {
    const double turn = 4.0 * units::kPi * n / 400.0;
    nearest =
        std::min(nearest, distance(x, {8.0 * std::cos(turn), 8.0 * std::sin(turn), 1.6 * turn}));
  }
  return nearest - 1.5;
}

TriangleMesh surface_of_helix(const std::function<double(double)>& shade) {
  VolumeGeometry grid;
  grid.spacing = kSpacing;
  grid.size = {52, 52, 42};
  grid.origin = {-10.3, -10.2, -2.7};
  Volume<float> image(grid);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        image.at(i, j, k) =
            float(shade(distance_to_helix(grid.lps_from_index({double(i), double(j), double(k)}))));
  return meshing::detail::extract_isosurface(image);
}

/// Each vertex moved half way to the mean of its neighbours, some times.
TriangleMesh smoothed(TriangleMesh mesh, int times) {
  for (int t = 0; t < times; ++t) {
    std::vector<Vec3> sum(mesh.vertices.size());
    std::vector<double> count(mesh.vertices.size(), 0.0);
    for (const Triangle& triangle : mesh.triangles)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto from = std::size_t(triangle[c]), to = std::size_t(triangle[(c + 1) % 3]);
        sum[from] += mesh.vertices[to];
        count[from] += 1.0;
      }
    for (std::size_t v = 0; v < sum.size(); ++v)
      if (count[v] > 0.0) mesh.vertices[v] = 0.5 * mesh.vertices[v] + (0.5 / count[v]) * sum[v];
  }
  return mesh;
}

/// By an angle around (1, 2, 3).
TriangleMesh turned(TriangleMesh mesh, double degrees) {
  const Vec3 axis = normalized(Vec3{1.0, 2.0, 3.0});
  const double c = std::cos(degrees * units::kPi / 180.0),
               s = std::sin(degrees * units::kPi / 180.0);
  for (Vec3& x : mesh.vertices) x = c * x + s * cross(axis, x) + (1.0 - c) * dot(axis, x) * axis;
  return mesh;
}

double itself(double distance) { return distance; }
double only_side(double distance) { return distance < 0.0 ? -1.0 : 1.0; }

void expect_spacing(const std::optional<Lattice>& lattice, const Vec3& spacing) {
  ASSERT_TRUE(lattice);
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(lattice->spacing[a], spacing[a], 0.02 * spacing[a]);
}

TEST(Lattice, OfAnIsosurfaceIsThatOfItsVoxels) {
  const auto lattice = find_lattice(surface_of_helix(itself));
  expect_spacing(lattice, kSpacing);
  EXPECT_FALSE(lattice->is_of_blocks);
}

TEST(Lattice, IsStillThereWhenTheSurfaceIsSmoothed) {
  expect_spacing(find_lattice(smoothed(surface_of_helix(itself), 5)), kSpacing);
}

/// A bent vessel, eight voxels wide.
TriangleMesh surface_of_labels() {
  std::vector<std::array<int, 3>> cubes;
  for (int k = 0; k < 60; ++k)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i)
        if (std::hypot(i - 12.3 + 5.0 * std::sin(0.1 * k), j - 11.8) < 4.0)
          cubes.push_back({i, j, k});
  return surface_of_cubes(cubes);
}

TEST(Lattice, OfALabelMapIsOfBlocks) {
  const auto lattice = find_lattice(surface_of_labels());
  expect_spacing(lattice, {1.0, 1.0, 1.0});
  EXPECT_TRUE(lattice->is_of_blocks);
}

TEST(Lattice, OfALabelMapIsSeenInAnyPosition) {
  for (const double degrees : {7.0, 20.0, 45.0}) {
    const auto lattice = find_lattice(turned(surface_of_labels(), degrees));
    expect_spacing(lattice, {1.0, 1.0, 1.0});
    EXPECT_TRUE(lattice->is_of_blocks) << degrees;
  }
}

TEST(Lattice, OfAContourHalfWayBetweenLabelsIsOfBlocks) {
  // Vertices of marching tetrahedra then lie half way on edges and diagonals.
  const auto lattice = find_lattice(surface_of_helix(only_side));
  ASSERT_TRUE(lattice);
  EXPECT_TRUE(lattice->is_of_blocks);
}

TEST(Lattice, OfASmoothSurfaceIsNotSeenOutOfItsAxes) {
  for (const double degrees : {7.0, 20.0, 45.0})
    EXPECT_FALSE(find_lattice(turned(surface_of_helix(itself), degrees))) << degrees;
}

TEST(Lattice, IsNoneOfSurfacesOfOtherMaking) {
  EXPECT_FALSE(
      find_lattice(tests::make_tube(1.5, 40.0, 100, 24)));  // its rings are a grid along z alone
  EXPECT_FALSE(find_lattice(turned(tests::make_tube(1.5, 40.0, 100, 24), 30.0)));
  EXPECT_FALSE(find_lattice(make_torus(8.0, 1.5, 160, 24)));
  EXPECT_FALSE(find_lattice(make_sphere({1.0, 2.0, 3.0}, 5.0, 5)));
  EXPECT_FALSE(find_lattice({}));
}

TEST(Lattice, SaysWhatCanBeMeasuredOnTheSurface) {
  const Resolution made_of_voxels = resolution_of_surface(surface_of_helix(itself));
  EXPECT_NEAR(made_of_voxels.longest_mm, 0.6, 0.02);
  const double mean = std::cbrt(0.4 * 0.4 * 0.6);
  EXPECT_NEAR(lesion_options({}, made_of_voxels).voxel_mm, mean, 0.02);
  const Resolution drawn = resolution_of_surface(make_torus(8.0, 1.5, 160, 24));
  EXPECT_EQ(lesion_options({}, drawn).voxel_mm, 0.0);
  EXPECT_TRUE(lesion_options({}, drawn).edge_mm);
}

}  // namespace
}  // namespace angio::centerline::detail

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/volume.hpp"

namespace angio {
namespace {

/// Rotated about two axes, with three different spacings, off centre: nothing is symmetric.
VolumeGeometry oblique_grid() {
  const double a = 0.4, b = -0.7;
  const Mat3 about_z{{{std::cos(a), -std::sin(a), 0}, {std::sin(a), std::cos(a), 0}, {0, 0, 1}}};
  const Mat3 about_x{{{1, 0, 0}, {0, std::cos(b), -std::sin(b)}, {0, std::sin(b), std::cos(b)}}};
  return {{7, 9, 11}, {0.3, 0.5, 0.8}, {-12.0, 34.0, 5.5}, about_z * about_x};
}

constexpr Vec3 kSlope{1.5, -2.0, 0.75};
double linear(const Vec3& p) { return 10.0 + dot(kSlope, p); }

Volume<float> linear_volume() {
  Volume<float> volume(oblique_grid());
  const auto [ni, nj, nk] = volume.geometry.size;
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i)
        volume.at(i, j, k) =
            float(linear(volume.geometry.lps_from_index({double(i), double(j), double(k)})));
  return volume;
}

/// A random index at least `margin` voxels inside the border.
Vec3 random_index(std::mt19937& generator, const VolumeGeometry& grid, double margin) {
  Vec3 index;
  for (int axis = 0; axis < 3; ++axis)
    index[axis] = std::uniform_real_distribution<double>(
        margin, grid.size[std::size_t(axis)] - 1 - margin)(generator);
  return index;
}

TEST(VolumeGeometry, IndexAndLpsAreInverseOnAnObliqueGrid) {
  const VolumeGeometry grid = oblique_grid();
  std::mt19937 generator(2);
  for (int n = 0; n < 100; ++n) {
    const Vec3 index = random_index(generator, grid, -5.0);
    EXPECT_NEAR(distance(grid.index_from_lps(grid.lps_from_index(index)), index), 0.0, 1e-12);
  }
}

TEST(VolumeGeometry, NeighbouringVoxelsAreOneSpacingApartAlongTheGridsAxes) {
  const VolumeGeometry grid = oblique_grid();
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 next;
    next[axis] = 1.0;
    const Vec3 step = grid.lps_from_index(next) - grid.lps_from_index({});
    EXPECT_NEAR(norm(step), grid.spacing[axis], 1e-14);
    for (int row = 0; row < 3; ++row)
      EXPECT_NEAR(step[row], grid.direction(row, axis) * grid.spacing[axis], 1e-14);
  }
}

TEST(VolumeGeometry, OffsetsCountEveryVoxelOnceWithIFastest) {
  const VolumeGeometry grid = oblique_grid();
  std::size_t expected = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) EXPECT_EQ(grid.offset(i, j, k), expected++);
  EXPECT_EQ(expected, grid.voxel_count());
}

TEST(VolumeGeometry, CountsVoxelsBeyondTheRangeOfInt) {
  const VolumeGeometry grid{{4000, 4000, 1000}, {1, 1, 1}, {}, Mat3::identity()};
  EXPECT_EQ(grid.voxel_count(), 16'000'000'000u);
  EXPECT_EQ(grid.offset(3999, 3999, 999), 15'999'999'999u);
}

TEST(Interpolate, ReproducesALinearFunction) {
  const Volume<float> volume = linear_volume();
  std::mt19937 generator(3);
  for (int n = 0; n < 200; ++n) {
    const Vec3 p = volume.geometry.lps_from_index(random_index(generator, volume.geometry, 0.0));
    EXPECT_NEAR(interpolate(volume, p), linear(p), 2e-5);  // values are rounded to float
  }
}

TEST(Interpolate, GivesTheNearestBorderPointsValueOutside) {
  const Volume<float> volume = linear_volume();
  const VolumeGeometry& grid = volume.geometry;
  EXPECT_NEAR(interpolate(volume, grid.lps_from_index({-3.0, 4.0, 5.0})),
              linear(grid.lps_from_index({0.0, 4.0, 5.0})), 2e-5);
  EXPECT_NEAR(interpolate(volume, grid.lps_from_index({20.0, 30.0, 40.0})),
              linear(grid.lps_from_index({6.0, 8.0, 10.0})), 2e-5);
}

TEST(Interpolate, WorksOnASingleSlice) {
  Volume<float> slice({{2, 2, 1}, {1, 1, 1}, {}, Mat3::identity()});
  slice.values = {0, 1, 2, 3};
  EXPECT_DOUBLE_EQ(interpolate(slice, {0.5, 0.5, 0.0}), 1.5);
  EXPECT_DOUBLE_EQ(interpolate(slice, {0.5, 0.5, 7.0}), 1.5);
}

TEST(InterpolateGradient, OfALinearFunctionIsItsSlopeInPatientSpace) {
  const Volume<float> volume = linear_volume();
  std::mt19937 generator(4);
  for (int n = 0; n < 100; ++n) {
    const Vec3 p = volume.geometry.lps_from_index(random_index(generator, volume.geometry, 0.5));
    EXPECT_NEAR(distance(interpolate_gradient(volume, p), kSlope), 0.0, 2e-4);
  }
}

}  // namespace
}  // namespace angio

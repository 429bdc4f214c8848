#include <gtest/gtest.h>

#include <cmath>

#include "segmentation/detail/edge_image.hpp"
#include "segmentation/detail/fields.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation::detail {
namespace {

Volume<float> field(std::array<int, 3> size, Vec3 spacing,
                    const std::function<double(const Vec3&)>& f) {
  VolumeGeometry geometry;
  geometry.size = size;
  geometry.spacing = spacing;
  Volume<float> volume(geometry);
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i)
        volume.at(i, j, k) = float(f(geometry.lps_from_index({double(i), double(j), double(k)})));
  return volume;
}

TEST(Smooth, SpreadsAnImpulseToTheVarianceAskedForAlongEachAxis) {
  Volume<float> volume = field({41, 41, 21}, {0.5, 0.5, 1.0}, [](const Vec3&) { return 0.0; });
  volume.at(20, 20, 10) = 1.0f;
  const double sigma = 1.5;
  const auto smoothed = smooth(volume, sigma);
  const Vec3 middle = volume.geometry.lps_from_index({20, 20, 10});
  double sum = 0.0;
  Vec3 variance;
  for (int k = 0; k < 21; ++k)
    for (int j = 0; j < 41; ++j)
      for (int i = 0; i < 41; ++i) {
        const double w = double(smoothed.at(i, j, k));
        const Vec3 d = volume.geometry.lps_from_index({double(i), double(j), double(k)}) - middle;
        sum += w;
        for (int axis = 0; axis < 3; ++axis) variance[axis] += w * d[axis] * d[axis];
      }
  EXPECT_NEAR(sum, 1.0, 1e-5);
  // The kernel is averaged over a voxel (h^2 / 12) and cut at 3.5 sigma.
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(std::sqrt(variance[axis]), sigma, 0.02 * sigma) << "axis " << axis;
}

TEST(Smooth, LeavesAConstantAlone) {
  const auto volume = field({9, 8, 7}, {1, 1, 1}, [](const Vec3&) { return 3.0; });
  for (float v : smooth(volume, 2.0).values) EXPECT_NEAR(v, 3.0f, 1e-5f);
}

TEST(RefineNearZero, ReproducesQuadraticsAwayFromTheBorder) {
  const auto f = [](const Vec3& p) { return 1.0 + 0.3 * p.x * p.x - 0.2 * p.y * p.z + p.z; };
  const auto volume = field({30, 10, 10}, {1.0, 1.0, 2.0}, f);
  const auto fine = refine_near_zero(volume, {{2, 3, 4}}, 1e9f);
  EXPECT_NEAR(fine.geometry.spacing.z, 0.5, 1e-12);
  for (int k = 4; k < 32; ++k)
    for (int j = 3; j < 24; ++j)
      for (int i = 2; i < 56; ++i) {
        const Vec3 p = fine.geometry.lps_from_index({double(i), double(j), double(k)});
        EXPECT_NEAR(double(fine.at(i, j, k)), f(p), 1e-4 * (1.0 + std::abs(f(p))));
      }
}

TEST(RefineNearZero, KeepsTheSignFarAway) {
  const auto volume = field({60, 5, 5}, {1, 1, 1}, [](const Vec3& p) { return p.x - 40.0; });
  const auto fine = refine_near_zero(volume, {{2, 1, 1}}, 3.0f);
  EXPECT_EQ(fine.at(0, 2, 2), -3.0f);
  EXPECT_NEAR(double(fine.at(79, 2, 2)), -0.5, 1e-5);
}

TEST(CoarseField, ReproducesALinearFieldBetweenBlockCentres) {
  const auto f = [](const Vec3& p) { return 2.0 * p.x - p.y + 0.5 * p.z; };
  const auto volume = field({12, 12, 12}, {1, 1, 1}, f);
  const CoarseField coarse(block_average(volume, {3, 2, 4}), {3, 2, 4});
  std::vector<float> row(12);
  coarse.row(6, 5, 12, row.data());
  for (int i = 1; i < 11; ++i)
    EXPECT_NEAR(double(row[std::size_t(i)]), double(volume.at(i, 6, 5)), 1e-4);
}

TEST(Crop, KeepsEveryVoxelWhereItLies) {
  const auto volume = field({6, 5, 4}, {0.5, 1, 2}, [](const Vec3& p) { return p.x + 10 * p.z; });
  const auto part = crop(volume, {{2, 1, 1}, {3, 2, 2}});
  for (int k = 0; k < 2; ++k) {
    const Vec3 p = part.geometry.lps_from_index({1.0, 1.0, double(k)});
    EXPECT_NEAR(double(part.at(1, 1, k)), p.x + 10 * p.z, 1e-5);
  }
}

}  // namespace
}  // namespace angio::segmentation::detail

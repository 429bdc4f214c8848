#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reconstruction/detail/back_projection.hpp"

namespace angio::reconstruction::detail {
namespace {

/// A source 100 mm from the axis, a plane of samples of 0.5 mm.
PlaneFrame frame_at(double angle) {
  PlaneFrame frame;
  frame.source_x = float(std::cos(angle));
  frame.source_y = float(std::sin(angle));
  frame.across_x = -frame.source_y;
  frame.across_y = frame.source_x;
  frame.radius = 100.0F;
  frame.height = 1.5F;
  frame.first_u = -10.0F;
  frame.first_v = -8.0F;
  frame.per_mm = 2.0F;
  return frame;
}

FilteredFrames some_frames() {
  FilteredFrames frames;
  frames.u_count = 41;
  frames.v_count = 33;
  for (int f = 0; f < 3; ++f) frames.frames.push_back(frame_at(1.1 * f));
  for (int i = 0; i < 3 * 41 * 33; ++i) frames.values.push_back(float(i * 37 % 101) * 0.01F);
  return frames;
}

ColumnGrid some_grid() {
  ColumnGrid grid;
  grid.i_count = 12;
  grid.j_count = 10;
  grid.k_count = 27;  // not all of them come in eights
  grid.voxel = 0.75F;
  grid.first_x = -4.0F;
  grid.first_y = -3.5F;
  grid.first_z = -9.0F;  // beyond the frames' edges, too
  grid.field_radius = 5.0F;
  return grid;
}

TEST(ViewColumn, IsWhereTheRayMeetsThePlane) {
  const PlaneFrame frame = frame_at(0.6);
  const float x = 3.0F, y = -2.0F, z = 4.0F;
  // The plane's point is on the source's ray through (x, y, z).
  const double sx = 100.0 * std::cos(0.6), sy = 100.0 * std::sin(0.6), sz = 1.5;
  const double depth = 100.0 - (x * std::cos(0.6) + y * std::sin(0.6));
  const double part = 100.0 / depth;
  const double u = (sx + part * (x - sx)) * -std::sin(0.6) + (sy + part * (y - sy)) * std::cos(0.6);
  const double v = sz + part * (z - sz);
  const ColumnView view = view_column(frame, x, y);
  EXPECT_NEAR(view.u, (u + 10.0) * 2.0, 1e-4);
  EXPECT_NEAR(view.v + view.v_per_mm * z, (v + 8.0) * 2.0, 1e-4);
  EXPECT_NEAR(view.weight, part * part, 1e-6);
}

/// What the GPU does for each voxel is what the CPU does for a column: here with the frame looked
/// up by hand, where a texture would.
TEST(BackProjection, OfAColumnIsThatOfItsStretches) {
  const FilteredFrames frames = some_frames();
  const ColumnGrid grid = some_grid();
  const std::size_t voxels =
      std::size_t(grid.i_count) * std::size_t(grid.j_count) * std::size_t(grid.k_count);
  std::vector<float> columns(voxels, 0.0F);
  back_project(frames, grid, columns);
  constexpr int kStretch = 8;
  int compared = 0;
  for (int j = 0; j < grid.j_count; ++j)
    for (int i = 0; i < grid.i_count; ++i) {
      const float x = grid.first_x + float(i) * grid.voxel,
                  y = grid.first_y + float(j) * grid.voxel;
      const float* column = columns.data() + std::size_t((j * grid.i_count + i) * grid.k_count);
      if (std::hypot(x, y) > grid.field_radius) {
        EXPECT_EQ(column[0], 0.0F);
        continue;
      }
      for (int k = 0; k < grid.k_count; k += kStretch) {
        float sums[kStretch] = {};
        for (std::size_t f = 0; f < frames.frames.size(); ++f)
          add_frame(
              frames.frames[f], frames.u_count,
              {x, y, grid.first_z + float(k) * grid.voxel, grid.voxel},
              [&](float u, float v) {
                const auto value = [&](int a, int b) {
                  const int au = std::clamp(a, 0, frames.u_count - 1),
                            bv = std::clamp(b, 0, frames.v_count - 1);
                  return frames.values[(f * 41 + std::size_t(au)) * 33 + std::size_t(bv)];
                };
                const int a = int(std::floor(u)), b = int(std::floor(v));
                const float s = u - float(a), t = v - float(b);
                return (1 - s) * ((1 - t) * value(a, b) + t * value(a, b + 1)) +
                       s * ((1 - t) * value(a + 1, b) + t * value(a + 1, b + 1));
              },
              sums);
        for (int n = 0; n < std::min(kStretch, grid.k_count - k); ++n, ++compared)
          ASSERT_NEAR(sums[n], column[k + n], 2e-4) << i << " " << j << " " << k + n;
      }
    }
  EXPECT_GT(compared, 1000);
}

}  // namespace
}  // namespace angio::reconstruction::detail

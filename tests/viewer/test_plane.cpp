#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "testing/viewer/shapes.hpp"
#include "viewer/detail/plane.hpp"
#include "viewer/detail/projection.hpp"

namespace angio::viewer::detail {
namespace {

double total_length(const std::vector<Segment>& segments) {
  double length = 0.0;
  for (const Segment& segment : segments) length += distance(segment[0], segment[1]);
  return length;
}

TEST(Cut, OfATubeIsItsPolygon) {
  const test::TubeShape shape{.depth = 0.0, .bend_mm = 0.0, .ring_vertex_count = 64};
  const auto segments = cut(test::make_tube(shape), {0, 0, 10.1}, {0, 0, 1});
  // Two triangles per side of the 64-gon; every piece lies on the polygon 2 n r sin(pi / n).
  EXPECT_NEAR(total_length(segments), 2.0 * 64 * shape.radius_mm * std::sin(units::kPi / 64), 1e-9);
  for (const Segment& segment : segments)
    for (const Vec3& end : segment) EXPECT_NEAR(end.z, 10.1, 1e-12);
}

TEST(Cut, ThroughCornersMeetsThemOnce) {
  const auto segments = cut(test::make_cube(), {0, 0, 0.5}, {0, 0, 1});
  EXPECT_NEAR(total_length(segments), 4.0, 1e-12);
  EXPECT_TRUE(cut(test::make_cube(), {0, 0, 5}, {0, 0, 1}).empty());
}

TEST(PlaneWindow, PixelsAndPointsAreInverse) {
  const PlaneWindow window{{1, 2, 3}, {0, 1, 0}, {0, 0, -1}, 7.0};
  const auto pixel = window.pixel_of(window.point_of(12.0, 88.5, 100), 100);
  EXPECT_NEAR(pixel.x, 12.0, 1e-12);
  EXPECT_NEAR(pixel.y, 88.5, 1e-12);
}

TEST(SamplePlane, IsExactForALinearVolumeAndMarksTheOutside) {
  VolumeGeometry grid;
  grid.size = {20, 20, 20};
  grid.spacing = {0.5, 0.7, 0.9};
  grid.origin = {-3, -4, -5};
  Volume<float> volume(grid);
  const auto value = [](const Vec3& p) { return 3.0 * p.x - 2.0 * p.y + 0.5 * p.z; };
  for (int k = 0; k < 20; ++k)
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i)
        volume.at(i, j, k) = float(value(grid.lps_from_index({double(i), double(j), double(k)})));
  const Vec3 center = grid.lps_from_index({9, 9, 9});
  const PlaneWindow inside{center, normalized(Vec3{1, 1, 0}), {0, 0, 1}, 2.0};
  const auto values = sample_plane(volume, inside, 16, -999.0f);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x)
      EXPECT_NEAR(values[std::size_t(16 * y + x)], value(inside.point_of(x, y, 16)), 1e-4);
  const PlaneWindow outside{center + Vec3{1000, 0, 0}, {1, 0, 0}, {0, 1, 0}, 2.0};
  for (const float v : sample_plane(volume, outside, 4, -999.0f)) EXPECT_EQ(v, -999.0f);
}

TEST(Percentile, IsTheRankedValueAndIgnoresWhatIsNotANumber) {
  EXPECT_EQ(percentile({5, 1, 4, 2, 3}, 0.0), 1.0f);
  EXPECT_EQ(percentile({5, 1, 4, 2, 3}, 0.5), 3.0f);
  EXPECT_EQ(percentile({5, 1, std::nanf(""), 2, 3}, 1.0), 5.0f);
  EXPECT_EQ(percentile({}, 0.5), 0.0f);
}

/// A volume with one bright voxel near a given point, its grid turned and mirrored at will.
struct OneVoxel {
  Volume<float> volume;
  Vec3 place;
};
OneVoxel make_one_voxel(const Mat3& direction) {
  VolumeGeometry grid;
  grid.size = {12, 15, 18};
  grid.spacing = {0.5, 0.6, 0.7};
  grid.direction = direction;
  OneVoxel result{Volume<float>(grid), grid.lps_from_index({3, 11, 5})};
  result.volume.at(3, 11, 5) = 1.0f;
  return result;
}

TEST(Projection, ShowsABrightVoxelWhereItsPixelIsForAnyOrientation) {
  for (const auto& columns :
       std::vector<std::array<Vec3, 3>>{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                        {{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}},
                                        {{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}},
                                        {{{0, -1, 0}, {0, 0, -1}, {1, 0, 0}}}}) {
    Mat3 direction;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) direction(r, c) = columns[std::size_t(c)][r];
    const OneVoxel one = make_one_voxel(direction);
    const VolumeGeometry& grid = one.volume.geometry;
    const VoxelBox whole{{0, 0, 0}, {grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1}};
    for (const Projection& projection : project_maximum(one.volume, whole)) {
      const auto pixel = projection.pixel_of(grid.index_from_lps(one.place));
      const auto x = std::size_t(std::lround(pixel.x)), y = std::size_t(std::lround(pixel.y));
      EXPECT_EQ(projection.values[y * std::size_t(projection.width) + x], 1.0f) << projection.name;
    }
  }
}

TEST(Projection, PutsThePatientsLeftAtTheRightAndTheHeadAtTheTop) {
  Mat3 direction;  // i runs to the feet, j to the right, k to the back
  direction(2, 0) = -1.0;
  direction(0, 1) = -1.0;
  direction(1, 2) = 1.0;
  const OneVoxel one = make_one_voxel(direction);
  const VolumeGeometry& grid = one.volume.geometry;
  const auto projections =
      project_maximum(one.volume, {{0, 0, 0}, {grid.size[0] - 1, grid.size[1] - 1, 17}});
  const auto pixel_at = [&](const Projection& projection, const Vec3& offset) {
    return projection.pixel_of(grid.index_from_lps(one.place + offset));
  };
  ASSERT_EQ(projections.size(), 3u);
  for (const Projection& p : projections) {
    const auto here = pixel_at(p, {});
    const auto to_left = pixel_at(p, {1, 0, 0});
    const auto to_back = pixel_at(p, {0, 1, 0});
    const auto to_head = pixel_at(p, {0, 0, 1});
    EXPECT_GT(p.name == "sagittal" ? to_back.x : to_left.x, here.x) << p.name;
    EXPECT_GT(p.name == "axial" ? to_back.y : -to_head.y, p.name == "axial" ? here.y : -here.y)
        << p.name;
  }
}

TEST(BoxAround, StaysInTheVolumeAndHoldsThePoints) {
  VolumeGeometry grid;
  grid.size = {10, 10, 10};
  const VoxelBox box = box_around(grid, {{4, 4, 4}, {6, 4, 4}}, 1.5);
  EXPECT_EQ(box.first, (std::array<int, 3>{2, 2, 2}));
  EXPECT_EQ(box.last, (std::array<int, 3>{8, 6, 6}));
  const VoxelBox outside = box_around(grid, {{100, 100, 100}}, 1.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_GE(outside.first[axis], 0);
    EXPECT_LE(outside.last[axis], 9);
    EXPECT_LE(outside.first[axis], outside.last[axis]);
  }
}

}  // namespace
}  // namespace angio::viewer::detail

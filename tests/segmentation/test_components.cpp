#include <gtest/gtest.h>

#include "segmentation/detail/components.hpp"

namespace angio::segmentation::detail {
namespace {

Volume<std::uint8_t> mask_of(std::array<int, 3> size,
                             const std::vector<std::array<int, 3>>& voxels) {
  VolumeGeometry geometry;
  geometry.size = size;
  Volume<std::uint8_t> mask(geometry, 0);
  for (const auto& [i, j, k] : voxels) mask.at(i, j, k) = 1;
  return mask;
}

TEST(Components, CornersJoinOnlyWhenAsked) {
  const auto mask = mask_of({4, 4, 4}, {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}});
  EXPECT_EQ(label_components(mask, Connectivity::faces).count(), 3);
  EXPECT_EQ(label_components(mask, Connectivity::corners).count(), 1);
}

TEST(Components, BranchesThatMeetLaterAreOnePiece) {
  // Two arms along k that join at the far end, so that their first runs get different numbers.
  std::vector<std::array<int, 3>> voxels;
  for (int k = 0; k < 5; ++k) {
    voxels.push_back({0, 0, k});
    voxels.push_back({4, 0, k});
  }
  for (int i = 0; i < 5; ++i) voxels.push_back({i, 0, 4});
  const auto pieces = label_components(mask_of({5, 1, 5}, voxels), Connectivity::faces);
  EXPECT_EQ(pieces.count(), 1);
  EXPECT_EQ(pieces.voxel_count[1], 13u);
}

TEST(Components, EverySetVoxelHasALabelAndNoOther) {
  const auto mask = mask_of({3, 3, 3}, {{0, 0, 0}, {2, 2, 2}, {2, 2, 1}});
  const auto pieces = label_components(mask, Connectivity::faces);
  ASSERT_EQ(pieces.count(), 2);
  for (std::size_t v = 0; v < mask.values.size(); ++v)
    EXPECT_EQ(pieces.label[v] > 0, mask.values[v] != 0);
  EXPECT_EQ(pieces.voxel_count[1] + pieces.voxel_count[2], 3u);
}

TEST(BoundingBox, KeepsThreeVoxelsOfMarginInsideTheGrid) {
  const auto box = bounding_box(mask_of({20, 20, 20}, {{10, 1, 10}}), 0.0);
  EXPECT_EQ(box.first, (std::array<int, 3>{7, 0, 7}));
  EXPECT_EQ(box.size, (std::array<int, 3>{7, 5, 7}));
}

}  // namespace
}  // namespace angio::segmentation::detail

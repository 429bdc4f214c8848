#include <gtest/gtest.h>

#include <algorithm>

#include "segmentation/detail/vessel_tree.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation::detail {
namespace {

/// A tube along z, and beside it a ball that hangs together with nothing.
Volume<float> tube_beside_ball(const Vec3& ball) {
  return image_of(TubeImage{}, [&](const Vec3& p) {
    return std::min(along_z(p, 1.2), distance(p, ball) - 2.0);
  });
}

/// Trunks of a length in all, at one place.
std::vector<TubeAxis> trunks_at(const VolumeGeometry& grid, const Vec3& place, double length_mm) {
  const Vec3 index = grid.index_from_lps(place);
  const std::size_t voxel = grid.offset(int(index.x), int(index.y), int(index.z));
  return {{1.5, {voxel}, length_mm, {400.0f}, {360.0f}}};
}

TEST(VesselTree, IsThePieceWithTheTrunksWhereTheseAreLongEnoughToTell) {
  const Vec3 ball{4.5, 4.5, 0.0}, tube{0.0, 0.0, 0.0};
  const Volume<float> volume = tube_beside_ball(ball);
  BloodLevel level;
  level.lumen = 400.0f;
  level.tissue = 40.0f;
  level.is_told = level.is_even = true;
  const auto holds_ball = [&](double trunk_mm, double tubes_trunk_mm) {
    std::vector<TubeAxis> trunks = trunks_at(volume.geometry, ball, trunk_mm);
    const auto of_tube = trunks_at(volume.geometry, tube, tubes_trunk_mm);
    trunks.insert(trunks.end(), of_tube.begin(), of_tube.end());
    const VesselTree tree = find_vessel_tree(volume, level, trunks, {}, Progress{});
    const Vec3 at = volume.geometry.index_from_lps(ball);
    return tree.mask.at(int(at.x), int(at.y), int(at.z)) != 0;
  };
  EXPECT_FALSE(holds_ball(3.0, 0.0));
  EXPECT_TRUE(holds_ball(20.0, 0.0));
  // Trunks that are nearly as long tell nothing.
  EXPECT_FALSE(holds_ball(11.0, 6.5));
  EXPECT_TRUE(holds_ball(11.0, 4.0));
  EXPECT_TRUE(holds_ball(30.0, 18.0));
}

}  // namespace
}  // namespace angio::segmentation::detail

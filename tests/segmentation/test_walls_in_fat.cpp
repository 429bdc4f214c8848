#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "segmentation/segmentation.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation {
namespace {

constexpr double kFat = -90.0, kWall = 60.0, kBloodInFat = 400.0;  // [HU]

/// A vessel along z with a wall, in fat beside muscle, as a blurred image shows it.
/// @param shift  of all intensities: by 200 none is a Hounsfield unit's
Volume<float> vessel_in_fat(double radius, double wall, double shift = 0.0) {
  constexpr double kMuscleFrom = 5.0;  // in x [mm]
  TubeImage outer{{44, 44, 60}, {0.35, 0.35, 0.35}, kWall + shift, kFat + shift, 0.35, 12.0, 3};
  TubeImage inner = outer;
  inner.lumen = kBloodInFat - kWall;
  inner.background = inner.noise_sd = 0.0;
  Volume<float> image = image_of(
      outer, [&](const Vec3& p) { return std::min(along_z(p, radius + wall), kMuscleFrom - p.x); });
  const auto blood = image_of(inner, [&](const Vec3& p) { return along_z(p, radius); });
  for (std::size_t v = 0; v < image.values.size(); ++v) image.values[v] += blood.values[v];
  return image;
}

/// Of the circle of the lumen's area, in the mean over the middle half [mm].
double diameter_of(const Volume<float>& image) {
  const Volume<float> level_set = segment_vessels(image, {}).level_set;
  const VolumeGeometry& grid = level_set.geometry;
  double share = 0.0;
  int slices = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    const Vec3 p = grid.lps_from_index({0.0, 0.0, double(k)});
    if (std::abs(p.z) > 5.0) continue;
    ++slices;
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)  // the part of a voxel inside a flat border
        share += std::clamp(0.5 - double(level_set.at(i, j, k)) / grid.spacing.x, 0.0, 1.0);
  }
  return 2.0 * std::sqrt(share / slices * grid.spacing.x * grid.spacing.y / std::numbers::pi);
}

// Half way to fat lies in the wall.
TEST(WallsInFat, AreNotLumen) {
  EXPECT_NEAR(diameter_of(vessel_in_fat(1.5, 0.75)), 3.0, 0.12);
  EXPECT_NEAR(diameter_of(vessel_in_fat(2.0, 0.75)), 4.0, 0.12);
}

TEST(WallsInFat, AreTakenForGrantedWhereABodyIsSeenInHounsfieldUnits) {
  const double radius = 1.5;  // and no wall at all
  EXPECT_NEAR(diameter_of(vessel_in_fat(radius, 0.0, 200.0)), 2.0 * radius, 0.12);
}

}  // namespace
}  // namespace angio::segmentation

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/units.hpp"
#include "segmentation/detail/bright_objects.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/plaque.hpp"
#include "segmentation/segmentation.hpp"
#include "tests/segmentation/tube_volume.hpp"

/// Calcified plaque narrows the lumen; it is none itself.
namespace angio::segmentation {
namespace {

constexpr double kTissue = 50.0, kBloodBeside = 400.0;
constexpr double kVesselRadius = 2.0, kHalfLength = 5.0, kVoxel = 0.4;  // mm

struct Plaque {
  double intensity = 1100.0;
  double rest = 0.5;                 ///< of the radius that is left in the middle
  bool is_one_sided = true;          ///< or all around
  double half_length = kHalfLength;  ///< [mm]
};

/// The lumen's radius along the vessel.
double lumen_radius(const Plaque& plaque, double z) {
  const double t = z / plaque.half_length;
  const double share = std::abs(t) < 1.0 ? 0.5 * (1.0 + std::cos(units::kPi * t)) : 0.0;
  return kVesselRadius * (1.0 - share * (1.0 - plaque.rest));
}

double lumen_middle(const Plaque& plaque, double z) {
  return plaque.is_one_sided ? kVesselRadius - lumen_radius(plaque, z) : 0.0;
}

/// A vessel along z whose lumen is narrowed in the middle, plaque between it and the wall, as a
/// scanner sees it: blurred, and averaged over voxels.
Volume<float> image_with(const Plaque& plaque) {
  constexpr int kFine = 2;  // along each edge of a voxel
  VolumeGeometry grid;
  grid.size = {50 * kFine, 50 * kFine, 130 * kFine};
  grid.spacing = (kVoxel / kFine) * Vec3{1.0, 1.0, 1.0};
  for (int a = 0; a < 3; ++a)
    grid.origin[a] = -0.5 * (grid.size[std::size_t(a)] - 1) * grid.spacing[a];
  Volume<float> fine(grid, float(kTissue));
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = grid.lps_from_index({double(i), double(j), double(k)});
        if (std::hypot(p.x, p.y) > kVesselRadius) continue;
        const double off = std::hypot(p.x - lumen_middle(plaque, p.z), p.y);
        fine.at(i, j, k) =
            float(off <= lumen_radius(plaque, p.z) ? kBloodBeside : plaque.intensity);
      }
  Volume<float> image = detail::block_average(detail::smooth(fine, 0.35), {kFine, kFine, kFine});
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0f, 20.0f);
  for (float& value : image.values) value += noise(random);
  return image;
}

/// Of the largest ball around a place of a section.
double diameter_at(const Volume<float>& level_set, double z) {
  constexpr double kStep = 0.05;
  double deepest = 0.0;
  for (double y = -4.0; y < 4.0; y += kStep)
    for (double x = -4.0; x < 4.0; x += kStep)
      deepest = std::max(deepest, -interpolate(level_set, {x, y, z}));
  return 2.0 * deepest;
}

void expect_true_lumen(const Plaque& plaque) {
  const Segmentation result = segment_vessels(image_with(plaque), {});
  EXPECT_NEAR(diameter_at(result.level_set, 0.0), 2.0 * kVesselRadius * plaque.rest, kVoxel);
  EXPECT_NEAR(diameter_at(result.level_set, 12.0), 2.0 * kVesselRadius, 0.5 * kVoxel);
  for (double z = -15.0; z < 15.0; z += 0.5)
    EXPECT_LT(interpolate(result.level_set, {lumen_middle(plaque, z), 0.0, z}), 0.0) << z;
}

TEST(Plaque, OnOneSideIsNoLumen) {
  expect_true_lumen({});
  expect_true_lumen({.rest = 0.4});
  expect_true_lumen({.intensity = 900.0});
  expect_true_lumen({.intensity = 1500.0});
}

TEST(Plaque, OfAFewCubicMillimetresIsNoLumen) {
  expect_true_lumen({.rest = 0.75, .half_length = 0.6});
  expect_true_lumen({.rest = 0.75, .half_length = 0.8});
}

TEST(Plaque, AllAroundIsNoLumen) {
  expect_true_lumen({.is_one_sided = false});
  expect_true_lumen({.rest = 0.4, .is_one_sided = false});
}

TEST(Plaque, ThatIsSoftIsNoLumenEither) { expect_true_lumen({.intensity = kTissue}); }

TEST(Plaque, DoesNotDependOnTheImagesUnit) {
  Volume<float> image = image_with({});
  const double in_hounsfield = diameter_at(segment_vessels(image, {}).level_set, 0.0);
  for (float& value : image.values) value *= 1e-4f;
  EXPECT_NEAR(diameter_at(segment_vessels(image, {}).level_set, 0.0), in_hounsfield, 0.02);
}

TEST(Plaque, IsToldOf) {
  const auto told = testing::Contains(testing::HasSubstr("calcified plaque"));
  EXPECT_THAT(segment_vessels(image_with({}), {}).warnings, told);
  SegmentationOptions all;
  all.exclude_bone = false;
  EXPECT_THAT(segment_vessels(image_with({}), all).warnings, testing::Not(told));
  EXPECT_THAT(segment_vessels(image_with({.intensity = kTissue}), {}).warnings, testing::Not(told));
}

/// Whether the largest bright piece of a volume is plaque.
bool is_plaque(const Volume<float>& volume) {
  Volume<std::uint8_t> mask(volume.geometry);
  for (std::size_t v = 0; v < mask.values.size(); ++v) mask.values[v] = volume.values[v] > 530.0f;
  const detail::Components pieces = detail::label_components(mask, detail::Connectivity::faces);
  const auto largest =
      std::size_t(std::max_element(pieces.voxel_count.begin() + 1, pieces.voxel_count.end()) -
                  pieces.voxel_count.begin());
  for (std::size_t v = 0; v < mask.values.size(); ++v)
    mask.values[v] = pieces.label[v] == std::int32_t(largest);
  std::vector<detail::VoxelBox> boxes(pieces.voxel_count.size());
  boxes[largest] = detail::bounding_box(mask, 0.0);
  std::vector<bool> candidates(boxes.size(), false);
  candidates[largest] = true;
  return detail::find_plaque(pieces, boxes, candidates, detail::find_tube_axes(volume), volume,
                             {float(kBloodBeside), 350.0f})[largest];
}

// Its wall is farther from the axis than that of any vessel that a balloon of a coronary fits.
TEST(Plaque, InTheWallOfAWideVesselIsFarFromItsAxis) {
  constexpr double kWide = 9.0, kThick = 2.0, kHalfLong = 4.0, kHalfHigh = 3.0;  // mm
  TubeImage image;
  image.size = {44, 44, 60};
  image.spacing = {0.7, 0.7, 0.7};
  image.blur_mm = 0.4;
  image.background = kTissue;
  image.lumen = kBloodBeside;
  Volume<float> volume = image_of(image, [&](const Vec3& p) { return along_z(p, kWide); });
  image.lumen = 1100.0;
  const Volume<float> plaque = image_of(image, [&](const Vec3& p) {
    return std::max({along_z(p, kWide), -along_z(p, kWide - kThick), std::abs(p.z) - kHalfLong,
                     std::abs(p.y) - kHalfHigh, -p.x});
  });
  for (std::size_t v = 0; v < volume.values.size(); ++v)
    volume.values[v] = std::max(volume.values[v], plaque.values[v]);
  EXPECT_TRUE(is_plaque(volume));
}

// Of a grain in the wall beside a throat of three voxels hardly any of the border is at blood.
TEST(Plaque, BesideATightThroatIsKnown) {
  constexpr double kThroat = 0.55, kHealthy = 1.4, kWall = 0.9, kGrain = 1.2;  // mm
  VolumeGeometry grid;
  grid.size = {60, 60, 120};
  grid.spacing = 0.5 * kVoxel * Vec3{1.0, 1.0, 1.0};
  for (int a = 0; a < 3; ++a)
    grid.origin[a] = -0.5 * (grid.size[std::size_t(a)] - 1) * grid.spacing[a];
  Volume<float> fine(grid, -90.0f);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = grid.lps_from_index({double(i), double(j), double(k)});
        const double t = std::min(std::abs(p.z) / 5.0, 1.0), off = std::hypot(p.x, p.y);
        const double lumen =
            kHealthy - 0.5 * (1.0 + std::cos(units::kPi * t)) * (kHealthy - kThroat);
        const bool is_grain = std::hypot(p.x - kThroat - 0.8 * kGrain, p.y, p.z) < kGrain;
        if (off < lumen)
          fine.at(i, j, k) = float(kBloodBeside);
        else if (is_grain)
          fine.at(i, j, k) = 900.0f;
        else if (off < lumen + kWall)
          fine.at(i, j, k) = float(kTissue);
      }
  EXPECT_TRUE(is_plaque(detail::block_average(detail::smooth(fine, 0.35), {2, 2, 2})));
}

// In a trunk the most of what is tubular is no blood: vessels in lung and liver, far darker.
TEST(Plaque, IsToldByBloodsOwnLevelWhereThatIsKnown) {
  const Volume<float> volume = image_with({});
  std::vector<detail::TubeAxis> axes = detail::find_tube_axes(volume);
  detail::TubeAxis dark{kVesselRadius, {}, kVoxel, {}, {}};
  for (std::size_t v = 0; v < 3000; ++v) {
    dark.voxels.push_back(v);
    dark.intensity.push_back(volume.values[v]);
    dark.contrast.push_back(300.0f);
  }
  axes.push_back(dark);
  const auto told = testing::Contains(testing::HasSubstr("calcified plaque"));
  const detail::BloodLevel blood{float(kBloodBeside), float(kTissue), true};
  EXPECT_THAT(detail::find_bright_objects(volume, axes, blood, {}).warnings, told);
  EXPECT_THAT(detail::find_bright_objects(volume, axes, {}, {}).warnings, testing::Not(told));
}

TEST(Plaque, IsNoDenserVesselThatCrosses) {
  EXPECT_TRUE(is_plaque(image_with({})));
  TubeImage image;
  image.size = {70, 50, 70};
  image.spacing = {0.4, 0.4, 0.4};
  image.background = kTissue;
  image.lumen = kBloodBeside;
  Volume<float> volume = image_of(image, [](const Vec3& p) { return along_z(p, kVesselRadius); });
  image.lumen = 900.0;
  const Volume<float> vein =
      image_of(image, [](const Vec3& p) { return std::hypot(p.y - 4.2, p.z) - kVesselRadius; });
  for (std::size_t v = 0; v < volume.values.size(); ++v)
    volume.values[v] = std::max(volume.values[v], vein.values[v]);
  EXPECT_FALSE(is_plaque(volume));
}

TEST(Plaque, IsNoPlugOfBrighterBlood) {
  constexpr double kWide = 4.0, kHalfPlug = 3.0;  // mm
  TubeImage image;
  image.size = {50, 50, 100};
  image.spacing = {0.4, 0.4, 0.4};
  image.background = kTissue;
  image.lumen = kBloodBeside;
  Volume<float> volume = image_of(image, [&](const Vec3& p) { return along_z(p, kWide); });
  image.lumen = 900.0;
  const Volume<float> plug = image_of(
      image, [&](const Vec3& p) { return std::max(along_z(p, kWide), std::abs(p.z) - kHalfPlug); });
  for (std::size_t v = 0; v < volume.values.size(); ++v)
    volume.values[v] = std::max(volume.values[v], plug.values[v]);
  EXPECT_FALSE(is_plaque(volume));
}

}  // namespace
}  // namespace angio::segmentation

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/error.hpp"
#include "segmentation/detail/label_map.hpp"
#include "segmentation/segmentation.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation {
namespace {

using testing::Contains;
using testing::HasSubstr;
using Shape = std::function<double(const Vec3&)>;

/// A label where voxels' centres lie inside.
Volume<float> labelled(const Shape& shape, const Vec3& spacing, float value = 1.0f) {
  TubeImage image{{64, 60, 56}, spacing, 1.0, 0.0, 0.2};
  auto volume = image_of(image, shape);
  for (float& v : volume.values) v = v > 0.5f ? value : 0.0f;
  return volume;
}

double lumen_mm3(const Segmentation& result) {
  const Vec3& h = result.mask.geometry.spacing;
  return double(std::count(result.mask.values.begin(), result.mask.values.end(), 1)) * h.x * h.y *
         h.z;
}

double labelled_mm3(const Volume<float>& volume) {
  const Vec3& h = volume.geometry.spacing;
  return double(volume.values.size() -
                std::size_t(std::count(volume.values.begin(), volume.values.end(), 0.0f))) *
         h.x * h.y * h.z;
}

TEST(LabelMap, HasTwoValuesOrWholeNumbersWithJumpsBetweenThem) {
  TubeImage image{{40, 40, 40}, {0.5, 0.5, 0.5}, 400, 0, 0.3};
  const Shape tube = [](const Vec3& p) { return along_z(p, 3.0); };
  const auto binary = detail::find_labels(labelled(tube, {0.5, 0.5, 0.5}, 255.0f));
  ASSERT_EQ(binary.size(), 1u);
  EXPECT_EQ(binary[0].value, 255.0);
  auto several = labelled(tube, {0.5, 0.5, 0.5}, 3.0f);
  const auto other = labelled(
      [](const Vec3& p) {
        return norm(p - Vec3{8, 0, 0}) - 4.0;
      },
      {0.5, 0.5, 0.5}, 7.0f);
  for (std::size_t v = 0; v < several.values.size(); ++v)
    if (other.values[v] > 0.0f) several.values[v] = other.values[v];
  const auto labels = detail::find_labels(several);
  ASSERT_EQ(labels.size(), 2u);
  EXPECT_EQ(labels[0].value, 3.0);
  EXPECT_EQ(labels[1].value, 7.0);

  // Blurred, noisy or clipped images in few whole numbers are images.
  for (const double noise : {0.0, 20.0}) {
    image.noise_sd = noise;
    auto scan = image_of(image, tube);
    for (float& v : scan.values) v = std::round(std::clamp(v / 20.0f, 0.0f, 15.0f));
    EXPECT_TRUE(detail::find_labels(scan).empty()) << noise;
  }
}

TEST(LabelMap, GivesASmoothLumenOfTheSameVolume) {
  const Vec3 oblique = normalized(Vec3{0.3, 0.2, 1.0});
  for (const double radius : {1.2, 2.0, 4.0})
    for (const Vec3& spacing : {Vec3{0.5, 0.5, 0.5}, Vec3{0.4, 0.4, 0.8}}) {
      const Shape tube = [&](const Vec3& p) {
        return std::max(norm(p - dot(p, oblique) * oblique) - radius,
                        std::abs(dot(p, oblique)) - 10.0);
      };
      const auto volume = labelled(tube, spacing);
      const auto result = segment_vessels(volume, {});
      EXPECT_NEAR(lumen_mm3(result) / labelled_mm3(volume), 1.0, 0.01) << radius;
      // The wall between the ends: off by much less than a label's staircase of half a voxel.
      double sum = 0.0;
      int count = 0;
      for (double along = -7.0; along < 7.0; along += 0.37)
        for (int ray = 0; ray < 24; ++ray) {
          const Vec3 across = normalized(cross(oblique, Vec3{1, 0, 0}));
          const Vec3 up = cross(oblique, across);
          const double turn = ray * 3.14159265 / 12;
          const double d = interpolate(
              result.level_set,
              along * oblique + radius * (std::cos(turn) * across + std::sin(turn) * up));
          sum += d * d;
          ++count;
        }
      EXPECT_LT(std::sqrt(sum / count), 0.16 * std::cbrt(spacing.x * spacing.y * spacing.z))
          << radius;
      for (const std::string& warning : result.warnings)
        EXPECT_EQ(warning.find("clipped"), std::string::npos);
    }
}

TEST(LabelMap, LeavesOutOrRefusesWhatIsTooLargeForVessels) {
  const Vec3 spacing{4.0, 4.0, 4.0};  // 256 x 240 x 224 mm
  Volume<float> volume = labelled([](const Vec3& p) { return along_z(p, 14.0); }, spacing, 1.0f);
  const Volume<float> body = labelled(
      [](const Vec3& p) { return std::abs(p.x) < 20.0 ? 1.0 : norm(p) - 100.0; }, spacing, 2.0f);
  for (std::size_t v = 0; v < volume.values.size(); ++v)
    if (volume.values[v] == 0.0f) volume.values[v] = body.values[v];
  const Segmentation result = segment_vessels(volume, {});
  EXPECT_THAT(result.warnings, Contains(HasSubstr("label 2")));
  EXPECT_LT(lumen_mm3(result), 3.0e5);
  SegmentationOptions asked;
  asked.labels = {2.0};
  EXPECT_GT(lumen_mm3(segment_vessels(volume, asked)), 1.75e6) << "who names it gets it";
  EXPECT_THROW((void)segment_vessels(body, {}), InputError);
}

TEST(LabelMap, TakesTheLabelsAskedForAndNamesThem) {
  auto volume = labelled([](const Vec3& p) { return along_z(p, 3.0); }, {0.5, 0.5, 0.5}, 3.0f);
  const auto other = labelled(
      [](const Vec3& p) {
        return norm(p - Vec3{5, 0, 0}) - 4.0;
      },
      {0.5, 0.5, 0.5}, 7.0f);
  for (std::size_t v = 0; v < volume.values.size(); ++v)
    if (other.values[v] > 0.0f) volume.values[v] = other.values[v];
  const auto all = segment_vessels(volume, {});
  EXPECT_NEAR(lumen_mm3(all), labelled_mm3(volume), 0.01 * labelled_mm3(volume));
  EXPECT_THAT(all.warnings, Contains(HasSubstr("label map")));
  SegmentationOptions options;
  options.labels = {7.0};
  EXPECT_NEAR(lumen_mm3(segment_vessels(volume, options)), labelled_mm3(other),
              0.01 * labelled_mm3(other));
  options.labels = {4.0};
  EXPECT_THROW(segment_vessels(volume, options), InputError);
  options.labels = {1.0};
  TubeImage image;
  EXPECT_THROW(
      segment_vessels(image_of(image, [](const Vec3& p) { return along_z(p, 1.5); }), options),
      InputError);
}

}  // namespace
}  // namespace angio::segmentation

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "segmentation/segmentation.hpp"
#include "tests/segmentation/tube_volume.hpp"

namespace angio::segmentation {
namespace {

/// Two tubes that cross beside each other: a wide one along z and a thin one in a plane beside it,
/// turned against it, their walls a gap apart (below zero: the lumens overlap).
struct Contact {
  double angle_degrees;
  double gap_mm;
};

double distance_to_contact(const Contact& contact, const Vec3& p) {
  constexpr double kWide = 1.5, kThin = 0.9;
  const double angle = contact.angle_degrees * std::numbers::pi / 180.0;
  const Vec3 along{0.0, std::sin(angle), std::cos(angle)};
  const Vec3 from = p - Vec3{0.07 + kWide + kThin + contact.gap_mm, -0.04, 0.1};
  const double thin = norm(from - dot(from, along) * along) - kThin;
  return std::min(along_z(p, kWide), thin);
}

/// The image with exact partial volume of the voxels near walls: means over 4 x 4 x 4 points.
Volume<float> image_of(const Contact& contact, double noise) {
  constexpr int kPoints = 4;
  TubeImage image;
  image.size = {48, 48, 60};
  image.noise_sd = noise * (image.lumen - image.background);
  return image_of(image, [&](const Vec3& centre) {
    const double d = distance_to_contact(contact, centre);
    if (std::abs(d) > 1.0) return d;
    double share = 0.0;
    for (int k = 0; k < kPoints; ++k)
      for (int j = 0; j < kPoints; ++j)
        for (int i = 0; i < kPoints; ++i) {
          const auto offset = [&](int n, int axis) {
            return ((n + 0.5) / kPoints - 0.5) * image.spacing[axis];
          };
          const Vec3 point = centre + Vec3{offset(i, 0), offset(j, 1), offset(k, 2)};
          share += 0.5 * std::erfc(distance_to_contact(contact, point) /
                                   (std::sqrt(2.0) * image.blur_mm));
        }
    // The distance at which image_of gives that share, by bisection.
    share /= kPoints * kPoints * kPoints;
    double low = -2.0, high = 2.0;
    for (int step = 0; step < 40; ++step) {
      const double middle = 0.5 * (low + high);
      (0.5 * std::erfc(middle / (std::sqrt(2.0) * image.blur_mm)) > share ? low : high) = middle;
    }
    return 0.5 * (low + high);
  });
}

class TouchingVessels : public testing::TestWithParam<Contact> {};

TEST_P(TouchingVessels, AreJoinedNoFartherThanTheVoxelsAreBlurred) {
  const Contact contact = GetParam();
  const Volume<float> image = image_of(contact, 0.05);
  const auto result = segment_vessels(image, {});
  const VolumeGeometry& grid = result.level_set.geometry;
  const double voxel = image.geometry.spacing.x;
  std::size_t filled = 0, lost = 0, found = 0, there = 0;
  for (int k = 8; k + 8 < grid.size[2]; ++k)
    for (int j = 8; j + 8 < grid.size[1]; ++j)
      for (int i = 8; i + 8 < grid.size[0]; ++i) {
        const double truth =
            distance_to_contact(contact, grid.lps_from_index({double(i), double(j), double(k)}));
        const bool inside = result.level_set.at(i, j, k) < 0.0f;
        filled += inside && truth > voxel;
        lost += !inside && truth < -voxel;
        found += inside;
        there += truth < 0.0;
      }
  EXPECT_EQ(filled, 0u);
  EXPECT_EQ(lost, 0u);
  // Grooves finer than a voxel fill.
  EXPECT_NEAR(double(found) / double(there), 1.0, 0.02);
}

INSTANTIATE_TEST_SUITE_P(Angles, TouchingVessels,
                         testing::Values(Contact{0.0, -0.1}, Contact{0.0, 0.0}, Contact{15.0, -0.3},
                                         Contact{45.0, -0.2}, Contact{45.0, 0.0},
                                         Contact{90.0, -0.3}, Contact{90.0, 0.0}));

}  // namespace
}  // namespace angio::segmentation

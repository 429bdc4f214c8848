#pragma once

#include <cmath>
#include <functional>
#include <random>

#include "core/volume.hpp"

namespace angio::segmentation {

/// An image of a bright shape, as a scanner with a Gaussian blur sees it: the intensity of a
/// blurred flat boundary at the shape's signed distance (exact for a plane, good where sigma is far
/// below the radius).
struct TubeImage {
  std::array<int, 3> size{48, 48, 60};
  Vec3 spacing{0.3, 0.3, 0.3};
  double lumen = 400.0;
  double background = 40.0;
  double blur_mm = 0.15;
  double noise_sd = 0.0;  ///< intensity
  unsigned seed = 1;
};

/// @param signed_distance  of the shape [mm], negative inside, at a point in LPS
inline Volume<float> image_of(const TubeImage& image,
                              const std::function<double(const Vec3&)>& signed_distance) {
  VolumeGeometry geometry;
  geometry.size = image.size;
  geometry.spacing = image.spacing;
  for (int axis = 0; axis < 3; ++axis)
    geometry.origin[axis] = -0.5 * (image.size[std::size_t(axis)] - 1) * image.spacing[axis];
  Volume<float> volume(geometry);
  std::mt19937 random(image.seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  for (int k = 0; k < image.size[2]; ++k)
    for (int j = 0; j < image.size[1]; ++j)
      for (int i = 0; i < image.size[0]; ++i) {
        const double d =
            signed_distance(geometry.lps_from_index({double(i), double(j), double(k)}));
        const double share = 0.5 * std::erfc(d / (std::sqrt(2.0) * image.blur_mm));
        volume.at(i, j, k) = float(image.background + (image.lumen - image.background) * share +
                                   image.noise_sd * noise(random));
      }
  return volume;
}

/// Distance to a tube along z through the origin, slightly off the voxel centres.
inline double along_z(const Vec3& p, double radius) {
  return std::hypot(p.x - 0.07, p.y + 0.04) - radius;
}

}  // namespace angio::segmentation

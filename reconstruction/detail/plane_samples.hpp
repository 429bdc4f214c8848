#pragma once

#include <cmath>
#include <cstddef>

#include "core/vec3.hpp"

/// A frame's samples on its plane (plane_frames.hpp). The same code runs on CPU and GPU.
namespace angio::reconstruction::detail {

/// Where a frame's samples lie in its picture:
///
///     depth (column, row, 1) = at + i di + j dj
///
/// of sample (i, j) along u and v (Hartley, Zisserman, Multiple View Geometry, 2004, section 2.3).
struct PlaneMap {
  Vec3 at, di, dj;
  int columns = 0, rows = 0;
  bool is_exact = false;  ///< every sample lies on a pixel
};

struct PicturePlace {
  double column = 0.0, row = 0.0;
};
ANGIO_HOST_DEVICE inline PicturePlace place_of(const PlaneMap& map, int i, int j) {
  const Vec3 p = map.at + double(i) * map.di + double(j) * map.dj;
  return {p.x / p.z, p.y / p.z};
}

ANGIO_HOST_DEVICE inline int clamped(int value, int last) {
  return value < 0 ? 0 : value > last ? last : value;
}

/// Cubic convolution's weights of the pixels at -1, 0, 1, 2 for a place t in [0, 1) (Keys, IEEE
/// Trans. Acoust. Speech Signal Process. 29:1153, 1981, eq. 15, a = -1/2).
struct CubicWeights {
  float v[4];
};
ANGIO_HOST_DEVICE inline CubicWeights cubic_weights(float t) {
  return {{t * (-0.5F + t * (1.0F - 0.5F * t)), 1.0F + t * t * (-2.5F + 1.5F * t),
           t * (0.5F + t * (2.0F - 1.5F * t)), t * t * (-0.5F + 0.5F * t)}};
}

/// The picture's value at a place between pixels; beyond the edge the edge goes on.
/// @param pixels  shape [rows, columns]
ANGIO_HOST_DEVICE inline float interpolate_cubic(const float* pixels, int columns, int rows,
                                                 const PicturePlace& place) {
  const auto within = [](double value, int last) {
    return value < 0.0 ? 0.0 : value > last ? double(last) : value;
  };
  const double x = within(place.column, columns - 1), y = within(place.row, rows - 1);
  const int c0 = int(x), r0 = int(y);
  const CubicWeights wx = cubic_weights(float(x - c0)), wy = cubic_weights(float(y - r0));
  float sum = 0.0F;
  for (int b = 0; b < 4; ++b) {
    const float* line = pixels + std::size_t(clamped(r0 - 1 + b, rows - 1)) * std::size_t(columns);
    float part = 0.0F;
    for (int a = 0; a < 4; ++a) part += wx.v[a] * line[clamped(c0 - 1 + a, columns - 1)];
    sum += wy.v[b] * part;
  }
  return sum;
}

/// The value of sample (i, j).
ANGIO_HOST_DEVICE inline float sample_picture(const float* pixels, const PlaneMap& map, int i,
                                              int j) {
  const PicturePlace place = place_of(map, i, j);
  if (!map.is_exact) return interpolate_cubic(pixels, map.columns, map.rows, place);
  const int column = clamped(int(std::floor(place.column + 0.5)), map.columns - 1);
  const int row = clamped(int(std::floor(place.row + 0.5)), map.rows - 1);
  return pixels[std::size_t(row) * std::size_t(map.columns) + std::size_t(column)];
}

/// How a ray's slant weighs it: R / sqrt(R^2 + u^2 + v^2) (Feldkamp, Davis, Kress 1984, eq. 34).
/// @param along  v from the source's height [mm]
ANGIO_HOST_DEVICE inline float slant_weight(float radius, float across, float along) {
  return radius / std::sqrt(radius * radius + across * across + along * along);
}

}  // namespace angio::reconstruction::detail

#pragma once

#include "core/simd.hpp"
#include "core/vec3.hpp"

/// Packs of points: places all over memory into lanes and back.
namespace angio::simulation::detail {

/// A point of four numbers, so that a pack of points is loaded as a matrix and transposed.
struct PackedPoint {
  float x = 0.0F, y = 0.0F, z = 0.0F, unused = 0.0F;
};

namespace point_packs {

using Four [[gnu::vector_size(16)]] = float;
using Eight [[gnu::vector_size(32)]] = float;

inline Four row_of(const PackedPoint& p) {
  Four row;
  std::memcpy(&row, &p, sizeof row);
  return row;
}

/// The coordinates of eight points.
struct Columns {
  Eight x, y, z;
};

/// @param point  a PackedPoint by its lane
template <class Points>
Columns columns_of(const Points& point) {
  const auto pair = [&](int i) {
    return __builtin_shufflevector(row_of(point(i)), row_of(point(i + 4)), 0, 1, 2, 3, 4, 5, 6, 7);
  };
  const Eight a = pair(0), b = pair(1), c = pair(2), d = pair(3);
  const Eight ab = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
  const Eight cd = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
  const Eight ab_z = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
  const Eight cd_z = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
  return {__builtin_shufflevector(ab, cd, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(ab, cd, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(ab_z, cd_z, 0, 1, 8, 9, 4, 5, 12, 13)};
}

}  // namespace point_packs

/// @param point  a PackedPoint by its lane
template <int kWidth, class Points>
Vec3T<Pack<float, kWidth>> load_points(const Points& point) {
  static_assert(kWidth == 8 || kWidth == 16);
  using Lanes = Pack<float, kWidth>;
  const point_packs::Columns low = point_packs::columns_of(point);
  if constexpr (kWidth == 8) {
    return {Lanes::from(low.x), Lanes::from(low.y), Lanes::from(low.z)};
  } else {
    const auto high = point_packs::columns_of([&](int i) { return point(i + 8); });
    const auto joined = [](const point_packs::Eight& a, const point_packs::Eight& b) {
      return Lanes::from(
          __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
    };
    return {joined(low.x, high.x), joined(low.y, high.y), joined(low.z, high.z)};
  }
}

template <int kWidth>
void store_points(const Vec3T<Pack<float, kWidth>>& x, PackedPoint* points) {
  for (int i = 0; i < kWidth; ++i) points[i] = {x.x[i], x.y[i], x.z[i], 0.0F};
}

}  // namespace angio::simulation::detail

#include "segmentation/detail/signed_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/parallel.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
using Offset = Vec3T<float>;  ///< from a voxel's centre to its closest point, along the axes [mm]

struct ClosestPoints {
  Volume<float> distance_squared;
  std::vector<Offset> offset;
};

/// Distance [mm] along one axis to the nearer crossing, signed by its side; 0: there is none.
float nearest_crossing(const Volume<float>& level, const std::array<int, 3>& voxel, int axis) {
  const float here = level.at(voxel[0], voxel[1], voxel[2]);
  const auto a = std::size_t(axis);
  float nearest = 0.0f;
  for (int side : {-1, 1}) {
    auto other = voxel;
    other[a] += side;
    if (other[a] < 0 || other[a] >= level.geometry.size[a]) continue;
    const float there = level.at(other[0], other[1], other[2]);
    if ((here < 0.0f) == (there < 0.0f)) continue;
    const float way = std::max(here / (here - there), 1e-4f) * float(level.geometry.spacing[axis]);
    if (nearest == 0.0f || way < std::abs(nearest)) nearest = float(side) * way;
  }
  return nearest;
}

ClosestPoints first_layer(const Volume<float>& level) {
  ClosestPoints points{Volume<float>(level.geometry, kFar),
                       std::vector<Offset>(level.geometry.voxel_count())};
  const auto [ni, nj, nk] = level.geometry.size;
  parallel_for(nk, [&, ni = ni, nj = nj](std::ptrdiff_t k) {
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i) {
        Offset n;
        for (int axis = 0; axis < 3; ++axis) {
          const float crossing = nearest_crossing(level, {i, j, int(k)}, axis);
          n[axis] = crossing == 0.0f ? 0.0f : 1.0f / crossing;
        }
        const float squared = norm_squared(n);
        if (squared == 0.0f) continue;
        const std::size_t v = level.geometry.offset(i, j, int(k));
        points.offset[v] = n / squared;
        points.distance_squared.values[v] = 1.0f / squared;
      }
  });
  return points;
}

/// One raster pass; `sign` is +1 to go from the first voxel to the last, -1 to go back. A voxel
/// looks at the 13 neighbours that the pass has already seen, then once more along its row.
void sweep(ClosestPoints& points, int sign) {
  const auto& geometry = points.distance_squared.geometry;
  const auto [ni, nj, nk] = geometry.size;
  const Offset h{float(geometry.spacing.x), float(geometry.spacing.y), float(geometry.spacing.z)};
  auto& best = points.distance_squared.values;
  const auto take = [&](std::size_t v, std::size_t from, const Offset& step) {
    if (best[from] == kFar) return;
    const Offset offset = points.offset[from] + step;
    const float squared = norm_squared(offset);
    if (squared < best[v]) {
      best[v] = squared;
      points.offset[v] = offset;
    }
  };
  for (int kk = 0; kk < nk; ++kk)
    for (int jj = 0; jj < nj; ++jj) {
      const int k = sign > 0 ? kk : nk - 1 - kk;
      const int j = sign > 0 ? jj : nj - 1 - jj;
      for (int ii = 0; ii < ni; ++ii) {
        const int i = sign > 0 ? ii : ni - 1 - ii;
        const std::size_t v = geometry.offset(i, j, k);
        for (int n = 0; n < 13; ++n) {  // the first 13 of 27 cells come before the middle one
          const int di = sign * (n % 3 - 1), dj = sign * (n / 3 % 3 - 1), dk = sign * (n / 9 - 1);
          if (geometry.contains(i + di, j + dj, k + dk))
            take(v, geometry.offset(i + di, j + dj, k + dk),
                 {float(di) * h.x, float(dj) * h.y, float(dk) * h.z});
        }
      }
      for (int ii = ni - 2; ii >= 0; --ii) {
        const int i = sign > 0 ? ii : ni - 1 - ii;
        take(geometry.offset(i, j, k), geometry.offset(i + sign, j, k),
             {float(sign) * h.x, 0.0f, 0.0f});
      }
    }
}

}  // namespace

Volume<float> signed_distance(const Volume<float>& level) {
  ClosestPoints points = first_layer(level);
  for (int sign : {1, -1, 1, -1}) sweep(points, sign);
  Volume<float> distance = std::move(points.distance_squared);
  for (std::size_t v = 0; v < distance.values.size(); ++v)
    distance.values[v] =
        std::copysign(std::sqrt(distance.values[v]), level.values[v] < 0.0f ? -1.0f : 1.0f);
  return distance;
}

}  // namespace angio::segmentation::detail

#include "segmentation/detail/signed_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "core/parallel.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kRefinedVoxels = 4.0;  ///< distance to which closest points are exact
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

/// Trilinear interpolation in index space with its border voxels repeated.
class LevelSampler {
 public:
  explicit LevelSampler(const Volume<float>& level) : level_(level) {}
  [[nodiscard]] float value(const Offset& index) const {
    int low[3], high[3];
    float t[3];
    for (int axis = 0; axis < 3; ++axis) {
      const int last = level_.geometry.size[std::size_t(axis)] - 1;
      const float x = std::clamp(index[axis], 0.0f, float(last));
      low[axis] = std::min(int(x), std::max(last - 1, 0));
      high[axis] = std::min(low[axis] + 1, last);
      t[axis] = x - float(low[axis]);
    }
    const auto line = [&](int j, int k) {
      return (1.0f - t[0]) * level_.at(low[0], j, k) + t[0] * level_.at(high[0], j, k);
    };
    return (1.0f - t[2]) * ((1.0f - t[1]) * line(low[1], low[2]) + t[1] * line(high[1], low[2])) +
           t[2] * ((1.0f - t[1]) * line(low[1], high[2]) + t[1] * line(high[1], high[2]));
  }
  /// Per mm along the axes, from points half a voxel to each side.
  [[nodiscard]] Offset gradient(const Offset& index) const {
    Offset g;
    for (int axis = 0; axis < 3; ++axis) {
      Offset a = index, b = index;
      a[axis] -= 0.5f;
      b[axis] += 0.5f;
      g[axis] = (value(b) - value(a)) / float(level_.geometry.spacing[axis]);
    }
    return g;
  }

 private:
  const Volume<float>& level_;
};

/// Way [mm] from a voxel to its closest point of the zero, by projecting the voxel onto the tangent
/// plane at the last estimate, three times:
///
///     y <- x - (F(y) + g . (x - y)) g / |g|^2,    g = grad F(y)
///
/// @param start  a first estimate
/// @return the start, where the iteration leaves the neighbourhood or does not reach the zero
Offset refine_closest(const LevelSampler& sampler, const VolumeGeometry& geometry,
                      const std::array<int, 3>& voxel, const Offset& start) {
  const Offset h{float(geometry.spacing.x), float(geometry.spacing.y), float(geometry.spacing.z)};
  const auto index = [&](const Offset& way) {
    return Offset{float(voxel[0]) + way.x / h.x, float(voxel[1]) + way.y / h.y,
                  float(voxel[2]) + way.z / h.z};
  };
  const float longest = norm(h);  ///< that the estimate may move
  Offset way = start;
  for (int iteration = 0; iteration < 3; ++iteration) {
    const Offset g = sampler.gradient(index(way));
    const float squared = norm_squared(g);
    if (!(squared > 0.0f)) return start;
    way = (-(sampler.value(index(way)) - dot(g, way)) / squared) * g;
    if (!(norm(way - start) < longest)) return start;
  }
  // Both are way-points of the zero; the better one lies nearer to it.
  const float missed = std::abs(sampler.value(index(way)));
  return missed <= std::abs(sampler.value(index(start))) + 0.02f ? way : start;
}

ClosestPoints first_layer(const Volume<float>& level) {
  ClosestPoints points{Volume<float>(level.geometry, kFar),
                       std::vector<Offset>(level.geometry.voxel_count())};
  const LevelSampler sampler(level);
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
        const Offset way = refine_closest(sampler, level.geometry, {i, j, int(k)}, n / squared);
        points.offset[v] = way;
        points.distance_squared.values[v] = std::max(norm_squared(way), 1e-12f);
      }
  });
  return points;
}

/// The 26 voxels around one.
struct Neighbor {
  int di, dj, dk;
  Offset step;  ///< [mm]
};

std::vector<Neighbor> neighbors_of(const VolumeGeometry& geometry) {
  std::vector<Neighbor> neighbors;
  for (int dk = -1; dk <= 1; ++dk)
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di)
        if (di != 0 || dj != 0 || dk != 0)
          neighbors.push_back({di,
                               dj,
                               dk,
                               {float(di * geometry.spacing.x), float(dj * geometry.spacing.y),
                                float(dk * geometry.spacing.z)}});
  return neighbors;
}

/// Voxels by distance, in steps of a fraction of a voxel; a voxel may wait in several steps.
class Front {
 public:
  explicit Front(float step) : step_(step) {}
  void push(std::size_t voxel, float distance_squared) {
    // A voxel may turn out nearer than the step being worked on; it still has to be handed on.
    const auto bucket = std::max(now_, std::size_t(std::sqrt(distance_squared) / step_));
    if (bucket >= buckets_.size()) buckets_.resize(bucket + 1);
    buckets_[bucket].push_back(voxel);
  }
  /// The voxels of the nearest step that has any; empty at the end.
  std::vector<std::size_t> take() {
    while (now_ < buckets_.size() && buckets_[now_].empty()) ++now_;
    return now_ < buckets_.size() ? std::exchange(buckets_[now_], {}) : std::vector<std::size_t>();
  }

 private:
  float step_;
  std::size_t now_ = 0;
  std::vector<std::vector<std::size_t>> buckets_;
};

/// Hands closest points on from near voxels to far ones, on each side of the surface by itself.
void propagate(ClosestPoints& points, const Volume<float>& level, float reach) {
  const auto& geometry = level.geometry;
  const auto neighbors = neighbors_of(geometry);
  auto& best = points.distance_squared.values;
  const Vec3& h = geometry.spacing;
  Front front(0.25f * float(std::min({h.x, h.y, h.z})));
  std::vector<std::uint8_t> done(best.size(), 0);
  for (std::size_t v = 0; v < best.size(); ++v)
    if (best[v] != kFar) front.push(v, best[v]);

  const auto hand_on = [&](std::size_t v) {
    const auto ni = std::size_t(geometry.size[0]), nj = std::size_t(geometry.size[1]);
    const int i = int(v % ni), j = int(v / ni % nj), k = int(v / ni / nj);
    const bool inside = level.values[v] < 0.0f;
    for (const auto& [di, dj, dk, step] : neighbors) {
      if (!geometry.contains(i + di, j + dj, k + dk)) continue;
      const std::size_t n = geometry.offset(i + di, j + dj, k + dk);
      if (done[n] || (level.values[n] < 0.0f) != inside) continue;
      const Offset offset = points.offset[v] - step;
      const float squared = norm_squared(offset);
      if (squared >= best[n] || (!inside && squared > reach * reach)) continue;
      best[n] = squared;
      points.offset[n] = offset;
      front.push(n, squared);
    }
  };
  for (auto voxels = front.take(); !voxels.empty(); voxels = front.take())
    for (std::size_t v : voxels)
      if (!std::exchange(done[v], std::uint8_t{1})) hand_on(v);
}

/// A point handed on is the closest of a neighbour; near the surface it is moved to a voxel's own.
void refine_near(ClosestPoints& points, const Volume<float>& level, float band) {
  const LevelSampler sampler(level);
  const auto [ni, nj, nk] = level.geometry.size;
  parallel_for(nk, [&, ni = ni, nj = nj](std::ptrdiff_t k) {
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i) {
        const std::size_t v = level.geometry.offset(i, j, int(k));
        if (!(points.distance_squared.values[v] < band * band)) continue;
        const Offset way =
            refine_closest(sampler, level.geometry, {i, j, int(k)}, points.offset[v]);
        points.distance_squared.values[v] =
            std::min(points.distance_squared.values[v], norm_squared(way));
      }
  });
}

}  // namespace

Volume<float> signed_distance(const Volume<float>& level, double reach_mm) {
  ClosestPoints points = first_layer(level);
  propagate(points, level, float(reach_mm));
  const Vec3& h = level.geometry.spacing;
  refine_near(points, level, float(kRefinedVoxels * std::max({h.x, h.y, h.z})));
  Volume<float> distance = std::move(points.distance_squared);
  for (std::size_t v = 0; v < distance.values.size(); ++v)
    distance.values[v] = level.values[v] < 0.0f
                             ? -std::sqrt(distance.values[v])
                             : std::min(std::sqrt(distance.values[v]), float(reach_mm));
  return distance;
}

}  // namespace angio::segmentation::detail

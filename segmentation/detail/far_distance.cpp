#include "segmentation/detail/far_distance.hpp"

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

constexpr int kCoarse = 2;  ///< voxels between those that are looked at
constexpr float kFar = std::numeric_limits<float>::infinity();
using Offset = Vec3T<float>;  ///< from a voxel's centre to its closest point, along the axes [mm]

/// Closest points on every kCoarse-th voxel.
struct CoarsePoints {
  VolumeGeometry geometry;
  std::vector<float> squared;
  std::vector<Offset> offset;
  std::vector<Offset> normal;  ///< of the surface there
  std::vector<std::uint8_t> is_inside;
  /// Whether there is none at the eight corners of a cell.
  [[nodiscard]] bool is_far(int i, int j, int k) const {
    for (int c = 0; c < 2; ++c)
      for (int b = 0; b < 2; ++b) {
        const std::size_t v = geometry.offset(i, j + b, k + c);
        if (squared[v] != kFar || squared[v + 1] != kFar) return false;
      }
    return true;
  }
};

CoarsePoints coarse_points(const Volume<float>& band, double band_mm) {
  const auto& fine = band.geometry;
  CoarsePoints points;
  points.geometry = fine;
  for (std::size_t a = 0; a < 3; ++a) {
    points.geometry.size[a] = (fine.size[a] - 1) / kCoarse + 2;
    points.geometry.spacing[int(a)] *= kCoarse;
  }
  points.squared.assign(points.geometry.voxel_count(), kFar);
  points.offset.resize(points.squared.size());
  points.normal.resize(points.squared.size());
  points.is_inside.assign(points.squared.size(), 0);
  parallel_for(points.geometry.size[2], [&](std::ptrdiff_t k) {
    for (int j = 0; j < points.geometry.size[1]; ++j)
      for (int i = 0; i < points.geometry.size[0]; ++i) {
        const std::array<int, 3> at{i * kCoarse, j * kCoarse, int(k) * kCoarse};
        if (!fine.contains(at[0], at[1], at[2])) continue;
        const float d = band.at(at[0], at[1], at[2]);
        const std::size_t v = points.geometry.offset(i, j, int(k));
        points.is_inside[v] = d < 0.0f;
        if (!(std::abs(d) < 0.75f * float(band_mm))) continue;
        Offset g;
        for (int axis = 0; axis < 3; ++axis) {
          auto low = at, high = at;
          const auto a = std::size_t(axis);
          low[a] = std::max(at[a] - 1, 0);
          high[a] = std::min(at[a] + 1, fine.size[a] - 1);
          g[axis] = (band.at(high[0], high[1], high[2]) - band.at(low[0], low[1], low[2])) /
                    float(fine.spacing[axis] * (high[a] - low[a]));
        }
        if (!(norm_squared(g) > 0.25f)) continue;
        points.normal[v] = normalized(g);
        points.offset[v] = -d * points.normal[v];
        points.squared[v] = d * d;
      }
  });
  return points;
}

/// Hands the points on; the coarse grid is small enough for one thread.
void propagate(CoarsePoints& points, float reach) {
  const auto& grid = points.geometry;
  const Offset h{float(grid.spacing.x), float(grid.spacing.y), float(grid.spacing.z)};
  const float step = 0.25f * std::min({h.x, h.y, h.z});
  std::vector<std::vector<std::uint32_t>> front(1);
  const auto push = [&](std::size_t v, std::size_t now) {
    const auto bucket = std::max(now, std::size_t(std::sqrt(points.squared[v]) / step));
    if (bucket >= front.size()) front.resize(bucket + 1);
    front[bucket].push_back(std::uint32_t(v));
  };
  for (std::size_t v = 0; v < points.squared.size(); ++v)
    if (points.squared[v] != kFar) push(v, 0);
  std::vector<std::uint8_t> is_done(points.squared.size(), 0);
  const auto ni = std::size_t(grid.size[0]), nj = std::size_t(grid.size[1]);
  const float reach_squared = reach * reach;
  for (std::size_t now = 0; now < front.size(); ++now)
    for (std::size_t n = 0; n < front[now].size(); ++n) {
      const std::size_t v = front[now][n];
      if (std::exchange(is_done[v], std::uint8_t{1})) continue;
      const std::array<int, 3> at{int(v % ni), int(v / ni % nj), int(v / ni / nj)};
      std::array<int, 3> low{}, high{};
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = at[a] > 0 ? -1 : 0;
        high[a] = at[a] + 1 < grid.size[a] ? 1 : 0;
      }
      const Offset here = points.offset[v], normal = points.normal[v];
      for (int dk = low[2]; dk <= high[2]; ++dk)
        for (int dj = low[1]; dj <= high[1]; ++dj) {
          const std::size_t row = grid.offset(at[0], at[1] + dj, at[2] + dk);
          const float y = here.y - float(dj) * h.y, z = here.z - float(dk) * h.z;
          for (int di = low[0]; di <= high[0]; ++di) {
            const auto other = std::size_t(std::ptrdiff_t(row) + di);
            const Offset way{here.x - float(di) * h.x, y, z};
            const float squared = norm_squared(way);
            if (squared >= points.squared[other] || is_done[other]) continue;
            if (squared > reach_squared && !points.is_inside[other]) continue;
            points.squared[other] = squared;
            points.offset[other] = way;
            points.normal[other] = normal;
            push(other, now);
          }
        }
    }
}

/// A row of the coarse grid beside one of the fine grid.
struct CoarseRow {
  std::size_t first = 0;  ///< of its points
  Offset way;             ///< to it, across the rows [mm]
};

/// Where the band ends: the nearest of the closest points around each voxel.
void fill_beyond(Volume<float>& distance, const CoarsePoints& points, float band, float reach) {
  const auto& fine = distance.geometry;
  const Offset h{float(fine.spacing.x), float(fine.spacing.y), float(fine.spacing.z)};
  parallel_for(fine.size[2], [&](std::ptrdiff_t k) {
    for (int j = 0; j < fine.size[1]; ++j) {
      float* row = &distance.at(0, j, int(k));
      const int ck = int(k) / kCoarse, cj = j / kCoarse;
      std::array<CoarseRow, 4> rows;
      for (int corner = 0; corner < 4; ++corner) {
        const int b = cj + (corner & 1), c = ck + (corner >> 1);
        rows[std::size_t(corner)] = {
            points.geometry.offset(0, b, c),
            {0.0f, float(b * kCoarse - j) * h.y, float(c * kCoarse - int(k)) * h.z}};
      }
      bool is_far = false;
      for (int i = 0; i < fine.size[0]; ++i) {
        const int ci = i / kCoarse;
        if (i % kCoarse == 0) is_far = points.is_far(ci, cj, ck);
        if (is_far && row[i] > 0.0f) row[i] = reach;
        if (is_far || std::abs(row[i]) < band) continue;
        float best = kFar, along = kFar;
        for (std::size_t corner = 0; corner < 8; ++corner) {
          const std::size_t v = rows[corner >> 1].first + std::size_t(ci) + (corner & 1);
          if (points.squared[v] == kFar) continue;
          const Offset& from = rows[corner >> 1].way;
          const Offset way =
              points.offset[v] +
              Offset{float((ci + int(corner & 1)) * kCoarse - i) * h.x, from.y, from.z};
          if (norm_squared(way) >= best) continue;
          best = norm_squared(way);
          along = std::abs(dot(way, points.normal[v]));  // the surface goes on beside the point
        }
        const float d = std::max(along, band);
        row[i] = row[i] < 0.0f ? -d : std::min(d, reach);
      }
    }
  });
}

}  // namespace

void continue_distance(Volume<float>& distance, double band_mm, double reach_mm) {
  CoarsePoints points = coarse_points(distance, band_mm);
  propagate(points, float(reach_mm));
  fill_beyond(distance, points, float(band_mm), float(reach_mm));
}

}  // namespace angio::segmentation::detail

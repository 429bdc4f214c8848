#include "centerline/detail/wall_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace angio::centerline {
namespace {

/// Where along [0, 1] the cubic through values at -1, 0, 1, 2 is zero; value[1] < 0 <= value[2].
double cubic_root(const double value[4]) {
  double low = 0.0, high = 1.0, t = value[1] / (value[1] - value[2]);
  const auto cubic = [&](double x) {
    return value[1] + x * ((-2.0 * value[0] - 3.0 * value[1] + 6.0 * value[2] - value[3]) / 6.0 +
                           x * (0.5 * (value[0] - 2.0 * value[1] + value[2]) +
                                x * (value[3] - 3.0 * value[2] + 3.0 * value[1] - value[0]) / 6.0));
  };
  for (int pass = 0; pass < 40; ++pass) {
    const double f = cubic(t);
    (f < 0.0 ? low : high) = t;
    if (high - low < 1e-7 || f == 0.0) break;
    const double slope = (cubic(t + 1e-4) - f) * 1e4;
    const double next = slope > 0.0 ? t - f / slope : -1.0;
    t = next > low && next < high ? next : 0.5 * (low + high);
  }
  return t;
}

/// The crossing between an inside voxel and its outside neighbour `side` (-1, +1) along an axis.
double crossing(const Volume<float>& level_set, const std::array<int, 3>& at, std::size_t axis,
                int side) {
  double value[4];
  bool smooth = true;
  for (int m = -1; m <= 2; ++m) {
    std::array<int, 3> to = at;
    to[axis] += m * side;
    if (!level_set.geometry.contains(to[0], to[1], to[2])) {
      smooth = false;
      value[m + 1] = 0.0;
      continue;
    }
    value[m + 1] = double(level_set.at(to[0], to[1], to[2]));
  }
  // Beyond a thin wall or across a narrow lumen the values turn round: there the line must do.
  smooth = smooth && value[0] < value[1] && value[2] < value[3];
  return smooth ? cubic_root(value) : value[1] / (value[1] - value[2]);
}

}  // namespace

WallPoints::WallPoints(const Volume<float>& level_set, const LumenVoxels& lumen, double voxel_mm) {
  const VolumeGeometry& grid = level_set.geometry;
  for (int v = 0; v < lumen.count(); ++v) {
    auto at = lumen.index(v);
    for (std::size_t a = 0; a < 3; ++a) at[a] += lumen.corner[a];
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        std::array<int, 3> to = at;
        to[axis] += side;
        if (!grid.contains(to[0], to[1], to[2]) || level_set.at(to[0], to[1], to[2]) < 0.0F)
          continue;
        Vec3 index{double(at[0]), double(at[1]), double(at[2])};
        index[int(axis)] += side * crossing(level_set, at, axis, side);
        points_.push_back(grid.lps_from_index(index));
      }
  }
  // The scanner's blur spreads the noise over about two voxels.
  correlation_length_ = 2.0 * std::max(grid.longest_spacing(), voxel_mm);
  build_grid(3.0 * grid.longest_spacing());
}

WallPoints::WallPoints(std::vector<Vec3> vertices) : points_(std::move(vertices)) {
  // Cells of about thirty points, as if they lay on the box's sides: only speed depends on it.
  const double count = std::max(1.0, double(points_.size()));
  Vec3 low = points_.empty() ? Vec3{} : points_.front(), high = low;
  for (const Vec3& p : points_)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  const Vec3 d = high - low;
  const double area = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x);
  build_grid(std::max(std::sqrt(10.0 * area / count), 1e-6));
}

WallPoints::Key WallPoints::key_of(const Vec3& p) const {
  return {int(std::floor(p.z / cell_)), int(std::floor(p.y / cell_)), int(std::floor(p.x / cell_))};
}

void WallPoints::build_grid(double cell) {
  cell_ = cell;
  std::vector<std::pair<Key, int>> order;
  order.reserve(points_.size());
  for (const Vec3& p : points_) order.emplace_back(key_of(p), int(order.size()));
  std::sort(order.begin(), order.end());
  std::vector<Vec3> sorted;
  sorted.reserve(points_.size());
  for (const auto& [key, index] : order) {
    const int place = int(sorted.size());
    sorted.push_back(points_[std::size_t(index)]);
    const bool is_new = rows_.empty() || rows_.back().k != key[0] || rows_.back().j != key[1];
    if (is_new) rows_.push_back({key[0], key[1], int(cells_.size()), 0});
    if (is_new || cells_.back().i != key[2]) cells_.push_back({key[2], place});
    rows_.back().end = int(cells_.size());
  }
  cells_.push_back({0, int(sorted.size())});
  points_ = std::move(sorted);
}

void WallPoints::collect(const Vec3& center, double reach, std::vector<int>& found) const {
  found.clear();
  const Vec3 r{reach, reach, reach};
  const Key low = key_of(center - r), high = key_of(center + r);
  const auto is_row_before = [](const Row& row, const std::pair<int, int>& kj) {
    return std::pair{row.k, row.j} < kj;
  };
  const auto is_cell_before = [](const Cell& cell, int i) { return cell.i < i; };
  for (int k = low[0]; k <= high[0]; ++k) {
    auto row = std::lower_bound(rows_.begin(), rows_.end(), std::pair{k, low[1]}, is_row_before);
    for (; row != rows_.end() && row->k == k && row->j <= high[1]; ++row) {
      const auto begin = cells_.begin() + row->begin, end = cells_.begin() + row->end;
      const int first = std::lower_bound(begin, end, low[2], is_cell_before)->first;
      const int last = std::lower_bound(begin, end, high[2] + 1, is_cell_before)->first;
      for (int n = first; n < last; ++n)
        if (norm_squared(points_[std::size_t(n)] - center) <= reach * reach) found.push_back(n);
    }
  }
}

double WallPoints::distance_to_nearest(const Vec3& place, double guess) const {
  if (points_.empty()) return std::numeric_limits<double>::infinity();
  for (double reach = std::max(1.1 * guess, 0.5 * cell_);; reach *= 2.0)
    if (const double nearest = nearest_squared(place, reach * reach); nearest < reach * reach)
      return std::sqrt(nearest);
}

double WallPoints::nearest_squared(const Vec3& place, double bound) const {
  const double reach = std::sqrt(bound);
  const Vec3 r{reach, reach, reach};
  const Key low = key_of(place - r), high = key_of(place + r);
  /// How far a place is from a cell along an axis.
  const auto away = [&](double at, int cell) {
    return std::max({0.0, cell * cell_ - at, at - (cell + 1) * cell_});
  };
  for (int k = low[0]; k <= high[0]; ++k) {
    const double dz = away(place.z, k);
    auto row = std::lower_bound(rows_.begin(), rows_.end(), std::pair{k, low[1]},
                                [](const Row& some, const std::pair<int, int>& kj) {
                                  return std::pair{some.k, some.j} < kj;
                                });
    for (; row != rows_.end() && row->k == k && row->j <= high[1]; ++row) {
      const double dy = away(place.y, row->j);
      const double rest = bound - dz * dz - dy * dy;
      if (rest < 0.0) continue;
      const double along = std::sqrt(rest);
      const int last = int(std::floor((place.x + along) / cell_));
      const auto end = cells_.begin() + row->end;
      auto cell = std::lower_bound(cells_.begin() + row->begin, end,
                                   int(std::floor((place.x - along) / cell_)),
                                   [](const Cell& some, int i) { return some.i < i; });
      for (; cell != end && cell->i <= last; ++cell)
        for (int n = cell->first; n < (cell + 1)->first; ++n)
          bound = std::min(bound, norm_squared(points_[std::size_t(n)] - place));
    }
  }
  return bound;
}

}  // namespace angio::centerline

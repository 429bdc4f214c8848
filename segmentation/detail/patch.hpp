#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/parallel.hpp"
#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// A part of a grid, to be worked on by itself.
struct Brick {
  std::array<int, 3> first{};
  std::array<int, 3> size{};
};

/// The bricks of a grid in which has_work(brick) is true, in the order of their first voxels.
template <class Predicate>
std::vector<Brick> bricks_with(const VolumeGeometry& grid, int edge, const Predicate& has_work) {
  std::array<int, 3> count{};
  for (std::size_t a = 0; a < 3; ++a) count[a] = (grid.size[a] + edge - 1) / edge;
  std::vector<Brick> all(std::size_t(count[0]) * std::size_t(count[1]) * std::size_t(count[2]));
  std::vector<char> is_kept(all.size(), 0);
  parallel_for_uneven(count[2], [&](std::ptrdiff_t k) {
    for (int j = 0; j < count[1]; ++j)
      for (int i = 0; i < count[0]; ++i) {
        const std::array<int, 3> place{i, j, int(k)};
        const std::size_t b =
            (std::size_t(k) * std::size_t(count[1]) + std::size_t(j)) * std::size_t(count[0]) +
            std::size_t(i);
        for (std::size_t a = 0; a < 3; ++a) {
          all[b].first[a] = place[a] * edge;
          all[b].size[a] = std::min(edge, grid.size[a] - all[b].first[a]);
        }
        is_kept[b] = has_work(all[b]) ? 1 : 0;
      }
  });
  std::vector<Brick> kept;
  for (std::size_t b = 0; b < all.size(); ++b)
    if (is_kept[b]) kept.push_back(all[b]);
  return kept;
}

/// Values of a brick and a border around it, which may reach beyond the grid.
struct Patch {
  std::array<int, 3> first{};  ///< voxel of the corner; may lie outside the grid
  std::array<int, 3> size{};
  std::vector<float> values;

  void resize(const std::array<int, 3>& corner, const std::array<int, 3>& extent) {
    first = corner;
    size = extent;
    values.assign(std::size_t(size[0]) * std::size_t(size[1]) * std::size_t(size[2]), 0.0f);
  }
  [[nodiscard]] std::size_t offset(int i, int j, int k) const {
    return (std::size_t(k) * std::size_t(size[1]) + std::size_t(j)) * std::size_t(size[0]) +
           std::size_t(i);
  }
  /// The value at a voxel of the grid; those behind it along the row follow.
  [[nodiscard]] const float* at(int i, int j, int k) const {
    return values.data() + offset(i - first[0], j - first[1], k - first[2]);
  }
  [[nodiscard]] float* row(int j, int k) { return values.data() + offset(0, j, k); }
  [[nodiscard]] const float* row(int j, int k) const { return values.data() + offset(0, j, k); }
};

/// Every ratio-th value of a volume around a brick; beyond the grid its border is repeated.
///
/// @param brick   in steps of the ratio
/// @param border  likewise, added on all sides
inline void gather(Patch& patch, const Volume<float>& volume, const std::array<int, 3>& ratio,
                   const Brick& brick, int border) {
  std::array<int, 3> corner{}, extent{};
  for (std::size_t a = 0; a < 3; ++a) {
    corner[a] = brick.first[a] - border;
    extent[a] = brick.size[a] + 2 * border;
  }
  patch.resize(corner, extent);
  const auto& size = volume.geometry.size;
  for (int k = 0; k < extent[2]; ++k)
    for (int j = 0; j < extent[1]; ++j) {
      const float* from = &volume.at(0, std::clamp((corner[1] + j) * ratio[1], 0, size[1] - 1),
                                     std::clamp((corner[2] + k) * ratio[2], 0, size[2] - 1));
      float* out = patch.row(j, k);
      const int step = ratio[0];
      const int low = std::clamp(-corner[0], 0, extent[0]);
      const int high = std::clamp((size[0] - 1) / step + 1 - corner[0], low, extent[0]);
      std::fill_n(out, low, from[0]);
      const float* inner = from + std::ptrdiff_t(corner[0] + low) * step;
      if (step == 1)
        std::copy_n(inner, high - low, out + low);
      else
        for (int i = 0; i < high - low; ++i) out[low + i] = inner[i * step];
      std::fill(out + high, out + extent[0], from[size[0] - 1]);
    }
}

}  // namespace angio::segmentation::detail

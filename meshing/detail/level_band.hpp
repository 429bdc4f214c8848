#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.hpp"
#include "core/volume.hpp"

namespace angio::meshing::detail {

/// Numbers in the rows of a grid along i, ascending in each. A row without any takes no room.
struct GridRows {
  std::vector<std::int64_t> row;      ///< k * size j + j, ascending
  std::vector<std::size_t> first{0};  ///< of each, into `at`; shape [row count + 1]
  std::vector<int> at;

  [[nodiscard]] std::size_t count() const { return row.size(); }
  [[nodiscard]] std::span<const int> entries(std::size_t place) const {
    return std::span(at).subspan(first[place], first[place + 1] - first[place]);
  }
  /// The place in `at` of a row's first entry, or where it would be.
  [[nodiscard]] std::size_t first_of(std::int64_t wanted) const;
  /// What the row k * size j + j holds; empty if it has no entries.
  [[nodiscard]] std::span<const int> find(std::int64_t wanted) const;
  /// Ends a row whose entries were appended to `at`.
  void end_row(std::int64_t id) {
    if (at.size() == first.back()) return;
    row.push_back(id);
    first.push_back(at.size());
  }
  void append(const GridRows& others);
};

/// Rows layer by layer, in parallel. @param fill  (k, rows) appends the rows of layer k
GridRows rows_by_layers(int layer_count, const auto& fill) {
  std::vector<GridRows> layers(std::size_t(std::max(layer_count, 0)));
  parallel_for_uneven(layer_count, [&](std::ptrdiff_t k) { fill(int(k), layers[std::size_t(k)]); });
  GridRows all;
  for (GridRows& layer : layers) {
    all.append(layer);
    layer = {};
  }
  return all;
}

/// The runs of nodes with a negative level: [begin, end) of each after the other.
GridRows runs_inside(const Volume<float>& level_set);

/// A level set at the nodes of a grid beside its zero surface; it grows with the surface's area.
struct LevelBand {
  VolumeGeometry grid;
  GridRows cells;            ///< runs [begin, end) of cells with corners on both sides
  GridRows nodes;            ///< the corners of these cells
  std::vector<float> level;  ///< [mm], negative inside, shape [nodes.at]
};

/// The band around the surface of what is inside, its levels -1 and 1. Runs may be empty.
LevelBand band_around(const VolumeGeometry& grid, const GridRows& runs_inside);

}  // namespace angio::meshing::detail

#include "meshing/detail/level_band.hpp"

#include <array>
#include <utility>

namespace angio::meshing::detail {
namespace {

std::ptrdiff_t place_of(const GridRows& rows, std::int64_t id) {
  return std::lower_bound(rows.row.begin(), rows.row.end(), id) - rows.row.begin();
}

/// The j, ascending, of the rows in layers k and k + 1, moved by 0 and by `step`, within the grid.
std::vector<int> rows_beside(const GridRows& rows, const VolumeGeometry& grid, int k, int step) {
  const std::int64_t ny = grid.size[1];
  std::vector<int> beside;
  for (auto place = place_of(rows, k * ny); place < place_of(rows, (k + 2) * ny); ++place)
    for (const int j :
         {int(rows.row[std::size_t(place)] % ny), int(rows.row[std::size_t(place)] % ny) + step})
      if (j >= 0 && j < grid.size[1]) beside.push_back(j);
  std::sort(beside.begin(), beside.end());
  beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
  return beside;
}

/// The cells of which some of the eight corners are inside, some outside.
GridRows crossed_cells(const VolumeGeometry& grid, const GridRows& inside) {
  const std::int64_t ny = grid.size[1];
  return rows_by_layers(grid.size[2] - 1, [&](int k, GridRows& layer) {
    std::vector<std::pair<int, int>> changes;  // i, change of the number of corners inside
    for (const int j : rows_beside(inside, grid, k, -1)) {
      if (j + 1 >= grid.size[1]) continue;
      const std::int64_t id = k * ny + j;
      changes.clear();
      for (const std::int64_t corner : {id, id + 1, id + ny, id + ny + 1}) {
        int change = 1;
        for (const int i : inside.find(corner)) {
          changes.emplace_back(i, change);      // of the corner at i
          changes.emplace_back(i - 1, change);  // of the one at i + 1
          change = -change;
        }
      }
      std::sort(changes.begin(), changes.end());
      int corner_count = 0;
      for (std::size_t c = 0; c + 1 < changes.size(); ++c) {
        corner_count += changes[c].second;
        const int begin = std::max(changes[c].first, 0);
        const int end = std::min(changes[c + 1].first, grid.size[0] - 1);
        if (begin >= end || corner_count == 0 || corner_count == 8) continue;
        if (layer.at.size() > layer.first.back() && layer.at.back() == begin)
          layer.at.back() = end;
        else
          layer.at.insert(layer.at.end(), {begin, end});
      }
      layer.end_row(id);
    }
  });
}

GridRows corners_of(const VolumeGeometry& grid, const GridRows& cells) {
  const std::int64_t ny = grid.size[1];
  return rows_by_layers(grid.size[2], [&](int k, GridRows& layer) {
    std::vector<std::array<int, 2>> runs;
    for (const int j : rows_beside(cells, grid, k - 1, 1)) {
      const std::int64_t id = k * ny + j;
      runs.clear();
      // No cell is in the last row of a layer, nor before the first one.
      for (const std::int64_t beside : {id, id - 1, id - ny, id - ny - 1}) {
        const auto ends = cells.find(beside);
        for (std::size_t e = 0; e < ends.size(); e += 2) runs.push_back({ends[e], ends[e + 1]});
      }
      std::sort(runs.begin(), runs.end());
      int next = 0;
      for (const auto& [begin, last] : runs) {
        for (int i = std::max(begin, next); i <= last; ++i) layer.at.push_back(i);
        next = std::max(next, last + 1);
      }
      layer.end_row(id);
    }
  });
}

}  // namespace

std::size_t GridRows::first_of(std::int64_t wanted) const {
  return first[std::size_t(place_of(*this, wanted))];
}

std::span<const int> GridRows::find(std::int64_t wanted) const {
  const auto place = std::size_t(place_of(*this, wanted));
  return place < count() && row[place] == wanted ? entries(place) : std::span<const int>();
}

void GridRows::append(const GridRows& others) {
  const std::size_t offset = at.size();
  row.insert(row.end(), others.row.begin(), others.row.end());
  for (std::size_t r = 0; r < others.count(); ++r) first.push_back(offset + others.first[r + 1]);
  at.insert(at.end(), others.at.begin(), others.at.end());
}

GridRows runs_inside(const Volume<float>& level_set) {
  const VolumeGeometry& grid = level_set.geometry;
  return rows_by_layers(grid.size[2], [&](int k, GridRows& layer) {
    for (int j = 0; j < grid.size[1]; ++j) {
      bool was_inside = false;
      for (int i = 0; i <= grid.size[0]; ++i) {
        const bool is_inside = i < grid.size[0] && level_set.at(i, j, k) < 0.0F;
        if (is_inside != std::exchange(was_inside, is_inside)) layer.at.push_back(i);
      }
      layer.end_row(std::int64_t(k) * grid.size[1] + j);
    }
  });
}

LevelBand band_around(const VolumeGeometry& grid, const GridRows& runs_inside) {
  LevelBand band{grid, crossed_cells(grid, runs_inside), {}, {}};
  band.nodes = corners_of(grid, band.cells);
  band.level.resize(band.nodes.at.size());
  parallel_for_uneven(std::ptrdiff_t(band.nodes.count()), [&](std::ptrdiff_t index) {
    const auto place = std::size_t(index);
    const auto runs = runs_inside.find(band.nodes.row[place]);
    auto behind = runs.begin();
    for (std::size_t n = band.nodes.first[place]; n < band.nodes.first[place + 1]; ++n) {
      while (behind != runs.end() && *behind <= band.nodes.at[n]) ++behind;
      band.level[n] = (behind - runs.begin()) % 2 == 1 ? -1.0F : 1.0F;
    }
  });
  return band;
}

}  // namespace angio::meshing::detail

#include "segmentation/detail/components.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/parallel.hpp"

namespace angio::segmentation::detail {
namespace {

/// Set voxels [first, last) of one row.
struct Run {
  int first;
  int last;
  std::int32_t parent;  ///< another run of the same piece, or itself
};

std::int32_t root_of(std::vector<Run>& runs, std::int32_t run) {
  while (runs[std::size_t(run)].parent != run) {
    auto& parent = runs[std::size_t(run)].parent;
    parent = runs[std::size_t(parent)].parent;
    run = parent;
  }
  return run;
}

/// The runs of every row, row by row; row r's are [start[r], start[r + 1]).
struct Runs {
  std::vector<Run> runs;
  std::vector<std::int32_t> start;
};

/// The runs of values for which is_set(value).
template <class Value, class IsSet>
Runs find_runs(const Volume<Value>& volume, const IsSet& is_set) {
  const auto [ni, nj, nk] = volume.geometry.size;
  std::vector<Runs> slices(std::size_t(nk), Runs{});
  parallel_for(nk, [&, ni = ni, nj = nj](std::ptrdiff_t k) {
    Runs& found = slices[std::size_t(k)];
    for (int j = 0; j < nj; ++j) {
      found.start.push_back(std::int32_t(found.runs.size()));
      const Value* values = &volume.at(0, j, int(k));
      for (int i = 0; i < ni;) {
        if (!is_set(values[i])) {
          ++i;
          continue;
        }
        const int first = i;
        while (i < ni && is_set(values[i])) ++i;
        found.runs.push_back({first, i, 0});
      }
    }
  });
  Runs all;
  for (const Runs& slice : slices) {
    const auto before = std::int32_t(all.runs.size());
    for (std::int32_t start : slice.start) all.start.push_back(before + start);
    all.runs.insert(all.runs.end(), slice.runs.begin(), slice.runs.end());
  }
  all.start.push_back(std::int32_t(all.runs.size()));
  for (std::size_t r = 0; r < all.runs.size(); ++r) all.runs[r].parent = std::int32_t(r);
  return all;
}

/// Joins the runs of two rows that touch; `slack` is 1 if corners count.
void join_rows(Runs& found, std::size_t row_a, std::size_t row_b, int slack) {
  std::int32_t a = found.start[row_a], b = found.start[row_b];
  const std::int32_t a_end = found.start[row_a + 1], b_end = found.start[row_b + 1];
  while (a < a_end && b < b_end) {
    const Run& run_a = found.runs[std::size_t(a)];
    const Run& run_b = found.runs[std::size_t(b)];
    if (run_a.first < run_b.last + slack && run_b.first < run_a.last + slack) {
      const std::int32_t root_a = root_of(found.runs, a), root_b = root_of(found.runs, b);
      // The smaller number wins, so that pieces keep the order of their first voxel.
      found.runs[std::size_t(std::max(root_a, root_b))].parent = std::min(root_a, root_b);
    }
    if (run_a.last < run_b.last)
      ++a;
    else
      ++b;
  }
}

void join_all_rows(Runs& found, const VolumeGeometry& geometry, Connectivity connectivity) {
  const int slack = connectivity == Connectivity::corners ? 1 : 0;
  const int nj = geometry.size[1];
  const auto row = [&](int j, int k) { return std::size_t(k) * std::size_t(nj) + std::size_t(j); };
  for (int k = 0; k < geometry.size[2]; ++k)
    for (int j = 0; j < nj; ++j) {
      if (j > 0) join_rows(found, row(j, k), row(j - 1, k), slack);
      if (k == 0) continue;
      for (int dj = -slack; dj <= slack; ++dj)
        if (j + dj >= 0 && j + dj < nj) join_rows(found, row(j, k), row(j + dj, k - 1), slack);
    }
}

Pieces pieces_of(Runs found, const VolumeGeometry& geometry, Connectivity connectivity) {
  join_all_rows(found, geometry, connectivity);
  Pieces pieces;
  pieces.runs.reserve(found.runs.size());
  std::vector<std::int32_t> label(found.runs.size(), 0);
  const auto nj = std::size_t(geometry.size[1]);
  for (std::size_t row = 0; row + 1 < found.start.size(); ++row)
    for (std::int32_t r = found.start[row]; r < found.start[row + 1]; ++r) {
      const auto root = std::size_t(root_of(found.runs, r));
      if (label[root] == 0) {
        pieces.voxel_count.push_back(0);
        label[root] = std::int32_t(pieces.count());
      }
      const auto& [first, last, parent] = found.runs[std::size_t(r)];
      pieces.runs.push_back({first, last, int(row % nj), int(row / nj), label[root]});
      pieces.voxel_count[std::size_t(label[root])] += std::size_t(last - first);
    }
  return pieces;
}

}  // namespace

Pieces find_pieces(const Volume<std::uint8_t>& mask, Connectivity connectivity) {
  return pieces_of(find_runs(mask, [](std::uint8_t value) { return value != 0; }), mask.geometry,
                   connectivity);
}

Pieces find_pieces_inside(const Volume<float>& level) {
  return pieces_of(find_runs(level, [](float value) { return value < 0.0f; }), level.geometry,
                   Connectivity::faces);
}

Pieces find_pieces_outside(const Volume<float>& level) {
  return pieces_of(find_runs(level, [](float value) { return !(value < 0.0f); }), level.geometry,
                   Connectivity::faces);
}

Components label_components(const Volume<std::uint8_t>& mask, Connectivity connectivity) {
  Pieces pieces = find_pieces(mask, connectivity);
  Components components{std::vector<std::int32_t>(mask.values.size(), 0),
                        std::move(pieces.voxel_count)};
  for (const Pieces::Run& run : pieces.runs)
    std::fill_n(
        components.label.begin() + std::ptrdiff_t(mask.geometry.offset(run.first, run.j, run.k)),
        run.last - run.first, run.label);
  return components;
}

VoxelBox bounding_box(const Volume<std::uint8_t>& mask, double margin_mm) {
  const auto& geometry = mask.geometry;
  std::array<int, 3> low = geometry.size;
  std::array<int, 3> high{-1, -1, -1};
  for (int k = 0; k < geometry.size[2]; ++k)
    for (int j = 0; j < geometry.size[1]; ++j)
      for (int i = 0; i < geometry.size[0]; ++i) {
        if (!mask.at(i, j, k)) continue;
        low = {std::min(low[0], i), std::min(low[1], j), std::min(low[2], k)};
        high = {std::max(high[0], i), std::max(high[1], j), std::max(high[2], k)};
      }
  VoxelBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    if (high[a] < 0) return {{0, 0, 0}, geometry.size};
    const int margin = std::max(3, int(std::ceil(margin_mm / geometry.spacing[int(a)])));
    box.first[a] = std::max(0, low[a] - margin);
    box.size[a] = std::min(geometry.size[a], high[a] + 1 + margin) - box.first[a];
  }
  return box;
}

}  // namespace angio::segmentation::detail

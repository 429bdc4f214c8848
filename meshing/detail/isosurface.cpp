#include "meshing/detail/isosurface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace angio::meshing::detail {
namespace {

/// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2 & 1). Kuhn's six tetrahedra walk from
/// corner 0 to corner 7 along the axes in every order; these are right-handed.
constexpr int kTets[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                             {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

/// The rotations of a tetrahedron, which keep its handedness.
constexpr int kEvenOrders[12][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 0, 3, 2},
                                    {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 0, 1, 3}, {2, 1, 3, 0},
                                    {2, 3, 0, 1}, {3, 0, 2, 1}, {3, 1, 0, 2}, {3, 2, 1, 0}};

class Marcher {
 public:
  explicit Marcher(const LevelBand& band)
      : band_(band), edge_vertices_(8 * band.level.size(), -1) {}

  TriangleMesh run() {
    const GridRows& nodes = band_.nodes;
    const std::int64_t ny = band_.grid.size[1];
    for (std::size_t row = 0; row < band_.cells.count(); ++row) {
      const std::int64_t id = band_.cells.row[row];
      Nodes node{};  // at the cell's lowest corner and beside it
      for (std::size_t r = 0; r < 4; ++r)
        node[r] = nodes.first_of(id + std::int64_t(r & 1U) + std::int64_t(r >> 1U) * ny);
      const std::span<const int> ends = band_.cells.entries(row);
      for (std::size_t e = 0; e < ends.size(); e += 2) {
        for (std::size_t& n : node)
          while (nodes.at[n] < ends[e]) ++n;
        for (int i = ends[e]; i < ends[e + 1]; ++i) {
          march_cell({i, int(id % ny), int(id / ny)}, node);
          for (std::size_t& n : node) ++n;
        }
      }
    }
    return std::move(mesh_);
  }

 private:
  using Nodes = std::array<std::size_t, 4>;  ///< of a cell, at its lower end along i

  void march_cell(const std::array<int, 3>& cell, const Nodes& nodes) {
    std::array<float, 8> values{};
    for (std::size_t c = 0; c < 8; ++c) values[c] = band_.level[nodes[c >> 1U] + (c & 1U)];
    for (const auto& tet : kTets) march_tet(cell, nodes, values, tet);
  }

  void march_tet(const std::array<int, 3>& cell, const Nodes& nodes,
                 const std::array<float, 8>& values, const int (&tet)[4]) {
    const auto inside = [&](int corner) { return values[std::size_t(tet[corner])] < 0.0F; };
    int count = 0;
    for (int c = 0; c < 4; ++c) count += inside(c) ? 1 : 0;
    if (count == 0 || count == 4) return;
    const bool lone_inside = count != 3;  // with three inside, the lone corner is the outside one
    const int lead_count = count == 2 ? 2 : 1;
    for (const auto& order : kEvenOrders) {
      bool fits = true;
      for (int c = 0; c < 4; ++c) fits &= inside(order[c]) == ((c < lead_count) == lone_inside);
      if (!fits) continue;
      const auto cut = [&](int a, int b) {
        return edge_vertex(cell, nodes, values, tet[order[a]], tet[order[b]]);
      };
      if (count == 2) {
        const int ac = cut(0, 2), ad = cut(0, 3), bd = cut(1, 3), bc = cut(1, 2);
        mesh_.triangles.push_back({ac, ad, bd});
        mesh_.triangles.push_back({ac, bd, bc});
      } else if (lone_inside) {
        mesh_.triangles.push_back({cut(0, 1), cut(0, 2), cut(0, 3)});
      } else {
        mesh_.triangles.push_back({cut(0, 1), cut(0, 3), cut(0, 2)});
      }
      return;
    }
  }

  int edge_vertex(const std::array<int, 3>& cell, const Nodes& nodes,
                  const std::array<float, 8>& values, int corner_a, int corner_b) {
    const int low = std::min(corner_a, corner_b);
    const int high = std::max(corner_a, corner_b);
    const std::array<int, 3> at{cell[0] + (low & 1), cell[1] + ((low >> 1) & 1),
                                cell[2] + (low >> 2)};
    const int direction = high ^ low;
    int& vertex = edge_vertices_[8 * (nodes[std::size_t(low >> 1)] + std::size_t(low & 1)) +
                                 std::size_t(direction)];
    if (vertex >= 0) return vertex;
    const double a = double(values[std::size_t(low)]);
    const double b = double(values[std::size_t(high)]);
    constexpr double kMargin = 0.1;
    const double t = std::clamp(a / (a - b), kMargin, 1.0 - kMargin);
    vertex = int(mesh_.vertices.size());
    mesh_.vertices.push_back(
        band_.grid.lps_from_index({at[0] + t * (direction & 1), at[1] + t * ((direction >> 1) & 1),
                                   at[2] + t * (direction >> 2)}));
    return vertex;
  }

  const LevelBand& band_;
  std::vector<int> edge_vertices_;  ///< shape [node, 8 directions], of the lower end; -1: none yet
  TriangleMesh mesh_;
};

}  // namespace

Volume<float> pad_level_set(const Volume<float>& level_set) {
  const VolumeGeometry& grid = level_set.geometry;
  std::array<int, 3> low = grid.size;
  std::array<int, 3> high{-1, -1, -1};
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        if (!(level_set.at(i, j, k) < 0.0F)) continue;
        const std::array<int, 3> at{i, j, k};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], at[axis]);
          high[axis] = std::max(high[axis], at[axis]);
        }
      }
  if (high[0] < 0)
    throw InputError(
        "the level set has no negative voxel (there is no lumen to mesh). Check the segmentation's "
        "seeds and intensity range");

  constexpr int kMargin = 3;  // voxels around the lumen, for gradients near its surface
  VolumeGeometry padded = grid;
  for (std::size_t axis = 0; axis < 3; ++axis)
    padded.size[axis] = high[axis] - low[axis] + 1 + 2 * kMargin;
  padded.origin = grid.lps_from_index(
      {double(low[0] - kMargin), double(low[1] - kMargin), double(low[2] - kMargin)});
  const double step = std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  Volume<float> result(padded);
  for (int k = 0; k < padded.size[2]; ++k)
    for (int j = 0; j < padded.size[1]; ++j)
      for (int i = 0; i < padded.size[0]; ++i) {
        const std::array<int, 3> at{i + low[0] - kMargin, j + low[1] - kMargin,
                                    k + low[2] - kMargin};
        int outside = 0;  // layers beyond the border
        std::array<int, 3> nearest{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          nearest[axis] = std::clamp(at[axis], 0, grid.size[axis] - 1);
          outside = std::max(outside, std::abs(at[axis] - nearest[axis]));
        }
        const float value = level_set.at(nearest[0], nearest[1], nearest[2]);
        result.at(i, j, k) = outside > 0 ? std::max(value, float(step * (outside - 0.5))) : value;
      }
  return result;
}

TriangleMesh extract_isosurface(const LevelBand& band) { return Marcher(band).run(); }

TriangleMesh extract_isosurface(const Volume<float>& level_set) {
  LevelBand band = band_around(level_set.geometry, runs_inside(level_set));
  const std::int64_t ny = band.grid.size[1];
  for (std::size_t row = 0; row < band.nodes.count(); ++row)
    for (std::size_t n = band.nodes.first[row]; n < band.nodes.first[row + 1]; ++n)
      band.level[n] = level_set.at(band.nodes.at[n], int(band.nodes.row[row] % ny),
                                   int(band.nodes.row[row] / ny));
  return extract_isosurface(band);
}

}  // namespace angio::meshing::detail

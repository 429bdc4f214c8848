#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/parallel.hpp"
#include "datasets/detail/cut_ends.hpp"
#include "datasets/detail/lumen_surface.hpp"

namespace angio::datasets::detail {
namespace {

constexpr LumenShape::Ends kContinued = LumenShape::Ends::continued;  // cut at last
constexpr int kSpreadSteps = 8;
constexpr int kProjectionSteps = 2;  ///< after each step of spreading
constexpr int kFinalProjectionSteps = 12;
constexpr double kOnWallMm = 1e-8;

using Cell = std::array<int, 3>;

/// The grid of cells; corner (i, j, k) is the lowest one of cell (i, j, k).
struct Grid {
  Vec3 origin;
  double cell_mm = 0.0;
  Cell size{};  ///< cells along each axis

  [[nodiscard]] Vec3 corner(const Cell& c) const {
    return origin + cell_mm * Vec3{double(c[0]), double(c[1]), double(c[2])};
  }
  [[nodiscard]] std::uint64_t key(const Cell& c) const {
    return (std::uint64_t(c[2]) * std::uint64_t(size[1] + 1) + std::uint64_t(c[1])) *
               std::uint64_t(size[0] + 1) +
           std::uint64_t(c[0]);
  }
};

Grid grid_over(const LumenShape& shape, double cell_mm) {
  Grid grid;
  grid.cell_mm = cell_mm;
  // A vessel goes on past its end by less than FlatEnd::reach.
  double reach = 0.0;
  for (const FlatEnd& end : shape.flat_ends()) reach = std::max(reach, end.reach);
  const double width = reach + 2.0 * cell_mm;
  const Vec3 margin{width, width, width};
  grid.origin = shape.lower_corner() - margin;
  const Vec3 extent = shape.upper_corner() + margin - grid.origin;
  for (int axis = 0; axis < 3; ++axis)
    grid.size[std::size_t(axis)] = int(std::ceil(extent[axis] / cell_mm));
  return grid;
}

/// Gathers the cells of a box that may meet the wall, in a fixed order.
void gather_cells(const LumenShape& shape, const Grid& grid, const Cell& lo, const Cell& hi,
                  std::vector<Cell>& cells) {
  Cell width{};
  std::size_t longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    width[axis] = hi[axis] - lo[axis];
    if (width[axis] > width[longest]) longest = axis;
  }
  const Vec3 center = 0.5 * (grid.corner(lo) + grid.corner(hi));
  const double reach = 0.5 * distance(grid.corner(lo), grid.corner(hi));
  if (std::abs(shape.signed_distance(center, kContinued)) > reach + shape.margin_mm()) return;
  if (width[longest] == 1) {
    cells.push_back(lo);
    return;
  }
  Cell middle_hi = hi, middle_lo = lo;
  middle_hi[longest] = middle_lo[longest] = lo[longest] + width[longest] / 2;
  gather_cells(shape, grid, lo, middle_hi, cells);
  gather_cells(shape, grid, middle_lo, hi, cells);
}

/// Signed distances at the corners of the gathered cells.
class CornerDistances {
 public:
  CornerDistances(const LumenShape& shape, const Grid& grid, const std::vector<Cell>& cells)
      : grid_(grid) {
    std::vector<Cell> corners;
    for (const Cell& cell : cells)
      for (int c = 0; c < 8; ++c) {
        const Cell corner{cell[0] + (c & 1), cell[1] + ((c >> 1) & 1), cell[2] + ((c >> 2) & 1)};
        if (index_.emplace(grid.key(corner), corners.size()).second) corners.push_back(corner);
      }
    values_.resize(corners.size());
    parallel_for(std::ptrdiff_t(corners.size()), [&](std::ptrdiff_t i) {
      values_[std::size_t(i)] =
          shape.signed_distance(grid_.corner(corners[std::size_t(i)]), kContinued);
    });
  }
  [[nodiscard]] double at(const Cell& corner) const {
    return values_[index_.at(grid_.key(corner))];
  }

 private:
  const Grid& grid_;
  std::unordered_map<std::uint64_t, std::size_t> index_;
  std::vector<double> values_;
};

/// A tetrahedron of Kuhn's subdivision of a cell, right-handed, by corner steps (bit i: along axis
/// i).
constexpr std::array<std::array<int, 4>, 6> kKuhnTets{
    {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}, {0, 3, 2, 7}, {0, 6, 4, 7}}};

/// The corners of a right-handed tet in an order that keeps it right-handed and has the inside ones
/// first; the index has bit i set where corner i is inside.
constexpr std::array<std::array<std::size_t, 4>, 16> kInsideFirst{{{0, 1, 2, 3},
                                                                   {0, 1, 2, 3},
                                                                   {1, 0, 3, 2},
                                                                   {0, 1, 2, 3},
                                                                   {2, 0, 1, 3},
                                                                   {0, 2, 3, 1},
                                                                   {1, 2, 0, 3},
                                                                   {0, 1, 2, 3},
                                                                   {3, 0, 2, 1},
                                                                   {0, 3, 1, 2},
                                                                   {1, 3, 2, 0},
                                                                   {0, 3, 1, 2},
                                                                   {2, 3, 0, 1},
                                                                   {0, 2, 3, 1},
                                                                   {1, 3, 2, 0},
                                                                   {0, 1, 2, 3}}};

class TetMarcher {
 public:
  TetMarcher(const Grid& grid, const CornerDistances& distances)
      : grid_(grid), distances_(distances) {}

  void march(const Cell& cell) {
    for (const std::array<int, 4>& tet : kKuhnTets) {
      std::array<Cell, 4> corner{};
      unsigned inside = 0;
      int inside_count = 0;
      for (std::size_t c = 0; c < 4; ++c) {
        corner[c] = {cell[0] + (tet[c] & 1), cell[1] + ((tet[c] >> 1) & 1),
                     cell[2] + ((tet[c] >> 2) & 1)};
        if (distances_.at(corner[c]) >= 0.0) continue;
        inside |= 1u << c;
        ++inside_count;
      }
      const auto& order = kInsideFirst[inside];
      const auto cut = [&](std::size_t a, std::size_t b) {
        return vertex_on(corner[order[a]], corner[order[b]]);
      };
      if (inside_count == 1) mesh_.triangles.push_back({cut(0, 1), cut(0, 2), cut(0, 3)});
      if (inside_count == 2) add_quad({cut(0, 2), cut(0, 3), cut(1, 3), cut(1, 2)});
      if (inside_count == 3) mesh_.triangles.push_back({cut(0, 3), cut(1, 3), cut(2, 3)});
    }
  }
  [[nodiscard]] TriangleMesh take() { return std::move(mesh_); }

 private:
  /// The vertex where the wall crosses an edge; both corners in either order give the same one.
  int vertex_on(Cell a, Cell b) {
    if (grid_.key(b) < grid_.key(a)) std::swap(a, b);
    const unsigned step =
        unsigned(b[0] - a[0]) + 2u * unsigned(b[1] - a[1]) + 4u * unsigned(b[2] - a[2]);
    const auto [place, is_new] =
        vertex_of_.emplace(8 * grid_.key(a) + step, int(mesh_.vertices.size()));
    if (is_new) {
      const double f_a = distances_.at(a), f_b = distances_.at(b);
      mesh_.vertices.push_back(grid_.corner(a) +
                               (f_a / (f_a - f_b)) * (grid_.corner(b) - grid_.corner(a)));
    }
    return place->second;
  }
  void add_quad(const std::array<int, 4>& q) {
    const auto at = [&](std::size_t i) { return mesh_.vertices[std::size_t(q[i])]; };
    const std::size_t first = distance(at(0), at(2)) <= distance(at(1), at(3)) ? 0 : 1;
    mesh_.triangles.push_back({q[first], q[first + 1], q[first + 2]});
    mesh_.triangles.push_back({q[first], q[first + 2], q[(first + 3) % 4]});
  }

  const Grid& grid_;
  const CornerDistances& distances_;
  TriangleMesh mesh_;
  std::unordered_map<std::uint64_t, int> vertex_of_;
};

TriangleMesh march_tets(const LumenShape& shape, const Grid& grid) {
  std::vector<Cell> cells;
  gather_cells(shape, grid, {0, 0, 0}, grid.size, cells);
  const CornerDistances distances(shape, grid, cells);
  TetMarcher marcher(grid, distances);
  for (const Cell& cell : cells) marcher.march(cell);
  return marcher.take();
}

}  // namespace

void spread_on_wall(const LumenShape& shape, TriangleMesh& mesh, const std::vector<char>& held,
                    int steps) {
  const std::vector<std::vector<int>> neighbors = vertex_neighbors(mesh);
  std::vector<Vec3> next(mesh.vertices.size());
  for (int step = 0; step <= steps; ++step) {
    const int projections = step < steps ? kProjectionSteps : kFinalProjectionSteps;
    parallel_for(std::ptrdiff_t(mesh.vertices.size()), [&](std::ptrdiff_t index) {
      const std::size_t v = std::size_t(index);
      Vec3 x = mesh.vertices[v];
      next[v] = x;
      if (!held.empty() && held[v]) return;
      if (step > 0) {  // first onto the wall as they are
        Vec3 mean;
        for (int w : neighbors[v])
          mean += mesh.vertices[std::size_t(w)] / double(neighbors[v].size());
        const Vec3 normal = shape.nearest_wall(x, kContinued).normal;
        x += 0.5 * (mean - x - dot(mean - x, normal) * normal);
      }
      for (int i = 0; i < projections; ++i) {
        const NearestWall wall = shape.nearest_wall(x, kContinued);
        x -= wall.distance * wall.normal;
        if (std::abs(wall.distance) < kOnWallMm) break;
      }
      next[v] = x;
    });
    mesh.vertices.swap(next);
  }
}

TriangleMesh tree_surface(const LumenShape& shape, double cell_mm) {
  TriangleMesh mesh = march_tets(shape, grid_over(shape, cell_mm));
  spread_on_wall(shape, mesh, {}, kSpreadSteps);
  return cut_ends(shape, std::move(mesh));
}

}  // namespace angio::datasets::detail

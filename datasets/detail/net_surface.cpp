#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/parallel.hpp"
#include "datasets/detail/lumen_surface.hpp"

namespace angio::datasets::detail {
namespace {

constexpr int kSpreadSteps = 8;
constexpr int kProjectionSteps = 2;       ///< after each step of spreading
constexpr int kFinalProjectionSteps = 8;  ///< where blended or cut, the distance is not exact

constexpr double kOnWallMm = 1e-7;

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
  const Vec3 margin{2.0 * cell_mm, 2.0 * cell_mm, 2.0 * cell_mm};
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
  if (std::abs(shape.signed_distance(center)) > reach + shape.margin_mm()) return;
  if (width[longest] == 1) {
    cells.push_back(lo);
    return;
  }
  Cell middle_hi = hi, middle_lo = lo;
  middle_hi[longest] = middle_lo[longest] = lo[longest] + width[longest] / 2;
  gather_cells(shape, grid, lo, middle_hi, cells);
  gather_cells(shape, grid, middle_lo, hi, cells);
}

Cell moved(Cell c, std::size_t axis, int by) {
  c[axis] += by;
  return c;
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
      values_[std::size_t(i)] = shape.signed_distance(grid_.corner(corners[std::size_t(i)]));
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

/// The mean of the places where the wall crosses the cell's edges; false if it does not.
bool net_vertex(const Grid& grid, const CornerDistances& f, const Cell& cell, Vec3& vertex) {
  Vec3 sum;
  int crossing_count = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 4; ++side) {
      const Cell a = moved(moved(cell, (axis + 1) % 3, side & 1), (axis + 2) % 3, side >> 1);
      const Cell b = moved(a, axis, 1);
      const double f_a = f.at(a), f_b = f.at(b);
      if ((f_a < 0.0) == (f_b < 0.0)) continue;
      sum += grid.corner(a) + (f_a / (f_a - f_b)) * (grid.corner(b) - grid.corner(a));
      ++crossing_count;
    }
  if (crossing_count > 0) vertex = sum / double(crossing_count);
  return crossing_count > 0;
}

void add_quad(TriangleMesh& mesh, const std::array<int, 4>& q) {
  const auto at = [&](std::size_t i) { return mesh.vertices[std::size_t(q[i])]; };
  if (distance(at(0), at(2)) <= distance(at(1), at(3))) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  } else {
    mesh.triangles.push_back({q[0], q[1], q[3]});
    mesh.triangles.push_back({q[1], q[2], q[3]});
  }
}

TriangleMesh build_net(const LumenShape& shape, const Grid& grid) {
  std::vector<Cell> cells;
  gather_cells(shape, grid, {0, 0, 0}, grid.size, cells);
  const CornerDistances f(shape, grid, cells);
  TriangleMesh mesh;
  std::unordered_map<std::uint64_t, int> vertex_of;
  for (const Cell& cell : cells) {
    Vec3 vertex;
    if (!net_vertex(grid, f, cell, vertex)) continue;
    vertex_of[grid.key(cell)] = int(mesh.vertices.size());
    mesh.vertices.push_back(vertex);
  }
  // Around every grid edge that crosses the wall, the vertices of its four cells make a quad.
  for (const Cell& cell : cells)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool starts_inside = f.at(cell) < 0.0;
      if (starts_inside == (f.at(moved(cell, axis, 1)) < 0.0)) continue;
      const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto vertex = [&](int du, int dv) {
        return vertex_of.at(grid.key(moved(moved(cell, u, du), v, dv)));
      };
      std::array<int, 4> quad{vertex(0, 0), vertex(-1, 0), vertex(-1, -1), vertex(0, -1)};
      if (!starts_inside) std::reverse(quad.begin(), quad.end());
      add_quad(mesh, quad);
    }
  return mesh;
}

/// Moves vertices towards the middle of their neighbours along the wall, then onto the wall.
void spread_on_wall(const LumenShape& shape, TriangleMesh& mesh) {
  const std::vector<std::vector<int>> neighbors = vertex_neighbors(mesh);
  std::vector<Vec3> next(mesh.vertices.size());
  for (int step = 0; step <= kSpreadSteps; ++step) {
    parallel_for(std::ptrdiff_t(mesh.vertices.size()), [&](std::ptrdiff_t index) {
      const std::size_t v = std::size_t(index);
      Vec3 x = mesh.vertices[v];
      if (step > 0) {
        Vec3 mean;
        for (int w : neighbors[v]) mean += mesh.vertices[std::size_t(w)];
        const Vec3 move = mean / double(neighbors[v].size()) - x;
        const Vec3 normal = shape.nearest_wall(x).normal;
        x += 0.5 * (move - dot(move, normal) * normal);
      }
      const int projections = step < kSpreadSteps ? kProjectionSteps : kFinalProjectionSteps;
      for (int i = 0; i < projections; ++i) {
        const NearestWall wall = shape.nearest_wall(x);
        if (std::abs(wall.distance) < kOnWallMm) break;
        x -= wall.distance * wall.normal;
      }
      next[v] = x;
    });
    mesh.vertices.swap(next);
  }
}

}  // namespace

TriangleMesh net_surface(const LumenShape& shape, double cell_mm) {
  TriangleMesh mesh = build_net(shape, grid_over(shape, cell_mm));
  spread_on_wall(shape, mesh);
  return mesh;
}

}  // namespace angio::datasets::detail

#include "formats/detail/mesh_cells.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace angio::formats::detail {
namespace {

using Corners = std::array<int, 4>;

struct Shape {
  std::size_t corners;
  std::vector<Corners> faces;  ///< of a flat cell itself; of a solid, seen from outside
};

const Shape& shape_of(CellShape shape) {
  static const std::array<Shape, 6> kShapes{
      {{3, {{0, 1, 2, -1}}},
       {4, {{0, 1, 2, 3}}},
       {4, {{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}}},
       {5, {{0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}}},
       {6, {{0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}},
       {8, {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}}}};
  return kShapes[std::size_t(shape)];
}

bool is_flat(CellShape shape) {
  return shape == CellShape::triangle || shape == CellShape::quadrilateral;
}

/// Faces that are there once, whichever way round they are seen.
std::vector<Corners> faces_of_one(const std::vector<Corners>& faces) {
  std::vector<std::pair<Corners, std::size_t>> sorted;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    Corners key = faces[f];
    std::sort(key.begin(), key.end());
    sorted.emplace_back(key, f);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::size_t> single;
  for (std::size_t i = 0; i < sorted.size();) {
    std::size_t next = i + 1;
    while (next < sorted.size() && sorted[next].first == sorted[i].first) ++next;
    if (next == i + 1) single.push_back(sorted[i].second);
    i = next;
  }
  std::sort(single.begin(), single.end());
  std::vector<Corners> result;
  for (const std::size_t f : single) result.push_back(faces[f]);
  return result;
}

}  // namespace

std::size_t corner_count(CellShape shape) { return shape_of(shape).corners; }

void CellSurface::add(CellShape shape, std::span<const int> nodes) {
  const std::span<const int> corners = nodes.first(corner_count(shape));
  Cell cell{{corners.begin(), corners.end()}, shape, corners_.size()};
  std::sort(cell.sorted.begin(), cell.sorted.end());
  cells_.push_back(std::move(cell));
  corners_.insert(corners_.end(), corners.begin(), corners.end());
}

std::vector<CellSurface::Face> CellSurface::faces() const {
  std::vector<std::size_t> order(cells_.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return cells_[a].sorted < cells_[b].sorted;
  });
  const auto same = [&](std::size_t a, std::size_t b) {
    return cells_[a].sorted == cells_[b].sorted;
  };
  order.erase(std::unique(order.begin(), order.end(), same), order.end());
  std::sort(order.begin(), order.end());
  std::vector<Face> flat, of_solids;
  for (const std::size_t c : order) {
    const Cell& cell = cells_[c];
    for (const Corners& corners : shape_of(cell.shape).faces) {
      Face face{-1, -1, -1, -1};
      for (std::size_t k = 0; k < corners.size(); ++k)
        if (corners[k] >= 0) face[k] = corners_[cell.first + std::size_t(corners[k])];
      (is_flat(cell.shape) ? flat : of_solids).push_back(face);
    }
  }
  return of_solids.empty() ? flat : faces_of_one(of_solids);
}

TriangleMesh CellSurface::over(const std::vector<Vec3>& points) const {
  const std::vector<Face> all = faces();
  std::vector<int> place(points.size(), -1);
  for (const Face& face : all)
    for (const int node : face)
      if (node >= 0) place[std::size_t(node)] = 0;
  TriangleMesh mesh;
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (place[p] < 0) continue;
    place[p] = int(mesh.vertices.size());
    mesh.vertices.push_back(points[p]);
  }
  const auto at = [&](int node) { return place[std::size_t(node)]; };
  for (const Face& face : all) {
    mesh.triangles.push_back({at(face[0]), at(face[1]), at(face[2])});
    if (face[3] >= 0) mesh.triangles.push_back({at(face[0]), at(face[2]), at(face[3])});
  }
  return mesh;
}

}  // namespace angio::formats::detail

#include "formats/detail/mesh_cells.hpp"

#include <algorithm>
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
  std::vector<Face>& faces = is_flat(shape) ? flat_ : of_solids_;
  for (const Corners& corners : shape_of(shape).faces) {
    Face face{-1, -1, -1, -1};
    for (std::size_t k = 0; k < corners.size(); ++k)
      if (corners[k] >= 0) face[k] = nodes[std::size_t(corners[k])];
    faces.push_back(face);
  }
}

TriangleMesh CellSurface::over(const std::vector<Vec3>& points) const {
  const std::vector<Face> faces = of_solids_.empty() ? flat_ : faces_of_one(of_solids_);
  std::vector<int> place(points.size(), -1);
  for (const Face& face : faces)
    for (const int node : face)
      if (node >= 0) place[std::size_t(node)] = 0;
  TriangleMesh mesh;
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (place[p] < 0) continue;
    place[p] = int(mesh.vertices.size());
    mesh.vertices.push_back(points[p]);
  }
  const auto at = [&](int node) { return place[std::size_t(node)]; };
  for (const Face& face : faces) {
    mesh.triangles.push_back({at(face[0]), at(face[1]), at(face[2])});
    if (face[3] >= 0) mesh.triangles.push_back({at(face[0]), at(face[2]), at(face[3])});
  }
  return mesh;
}

}  // namespace angio::formats::detail

#include "meshing/detail/long_edges.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "meshing/detail/edge_table.hpp"
#include "meshing/detail/hollow.hpp"
#include "meshing/detail/surface_query.hpp"
#include "meshing/surface_size.hpp"

namespace angio::meshing::detail {
namespace {

constexpr double kLong = 1.5, kParts = 0.5;  // of the lumen's width
constexpr double kFold = 0.1;  // of the median width: what is nearer is no wall across
constexpr double kAnyLength = std::numeric_limits<double>::infinity();

double length_of(const TriangleMesh& mesh, const EdgeKey& edge) {
  return distance(mesh.vertices[std::size_t(edge[0])], mesh.vertices[std::size_t(edge[1])]);
}

/// How long edges between two vertices may be [mm]; unset (infinite) where no edge was too long.
class Lengths {
 public:
  explicit Lengths(std::size_t vertex_count) : longest_(vertex_count, kAnyLength) {}
  void limit(const EdgeKey& edge, double length) {
    for (const int v : edge) longest_[std::size_t(v)] = std::min(longest_[std::size_t(v)], length);
  }
  [[nodiscard]] double of(const EdgeKey& edge) const {
    return std::max(longest_[std::size_t(edge[0])], longest_[std::size_t(edge[1])]);
  }
  void add_middle(const EdgeKey& edge) { longest_.push_back(of(edge)); }

 private:
  std::vector<double> longest_;  // at each vertex
};

/// Gives each triangle the middles of its edges that are split: in two, three or four.
/// @param middle  vertex in the middle of side c of triangle t; -1: the side is not split
template <class Middle>
std::vector<Triangle> split_triangles(const std::vector<Triangle>& triangles,
                                      const Middle& middle) {
  std::vector<Triangle> parts;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    std::size_t first = 0;  // a split side behind one that is not, where there is such a pair
    for (std::size_t c = 0; c < 3; ++c)
      if (middle(t, c) >= 0 && middle(t, (c + 2) % 3) < 0) first = c;
    const auto corner = [&](std::size_t c) { return triangles[t][(first + c) % 3]; };
    const auto side = [&](std::size_t c) { return middle(t, (first + c) % 3); };
    const int a = corner(0), b = corner(1), c = corner(2), ab = side(0), bc = side(1), ca = side(2);
    if (ab < 0)
      parts.push_back({a, b, c});
    else if (bc < 0)
      parts.insert(parts.end(), {{a, ab, c}, {ab, b, c}});
    else if (ca < 0)
      parts.insert(parts.end(), {{ab, b, bc}, {a, ab, bc}, {a, bc, c}});
    else
      parts.insert(parts.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return parts;
}

/// Splits every edge that is longer than allowed in its middle. @return how many
int split_once(TriangleMesh& mesh, Lengths& lengths) {
  const EdgeTable edges(mesh);
  std::vector<int> middle_of_side(3 * mesh.triangles.size(), -1);
  int count = 0;
  for (const EdgeTable::Edge& edge : edges) {
    if (length_of(mesh, edge.key) <= lengths.of(edge.key)) continue;
    for (const int side : edge.at) middle_of_side[std::size_t(side)] = int(mesh.vertices.size());
    mesh.vertices.push_back(
        0.5 * (mesh.vertices[std::size_t(edge.key[0])] + mesh.vertices[std::size_t(edge.key[1])]));
    lengths.add_middle(edge.key);
    ++count;
  }
  mesh.triangles = split_triangles(
      mesh.triangles, [&](std::size_t t, std::size_t c) { return middle_of_side[3 * t + c]; });
  return count;
}

/// Whether a quarter of the wall has long edges: less are caps and seams, which are as they should
/// be. A vessel's wall, whose two skins are near each other, is not coarse, either.
bool is_coarse(const TriangleMesh& mesh, const Lengths& lengths) {
  constexpr double kShare = 0.25;
  double all = 0.0, coarse = 0.0;
  std::vector<std::size_t> triangles;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double area = norm(area_vector_doubled(mesh, mesh.triangles[t]));
    all += area;
    for (std::size_t c = 0; c < 3; ++c) {
      const EdgeKey edge = edge_key(mesh.triangles[t][c], mesh.triangles[t][(c + 1) % 3]);
      if (length_of(mesh, edge) <= lengths.of(edge)) continue;
      coarse += area;
      triangles.push_back(t);
      break;
    }
  }
  if (coarse < kShare * all) return false;
  const std::vector<char> hollow = face_a_hollow(mesh, triangles);
  return double(std::count(hollow.begin(), hollow.end(), char(1))) < kShare * double(hollow.size());
}

}  // namespace

Count split_long_edges(TriangleMesh& mesh) {
  Count found;
  const double least = kFold * median_diameter(mesh);
  if (least <= 0.0) return found;
  Lengths lengths(mesh.vertices.size());
  const EdgeTable edges(mesh);
  const ClosestPoint wall(mesh);
  for (const EdgeTable::Edge& edge : edges) {
    const double length = length_of(mesh, edge.key);
    const int triangle = edge.at.front() / 3;
    if (length <= kLong * least) continue;
    const auto t = std::size_t(triangle), c = std::size_t(edge.at.front() % 3);
    const Vec3 middle = 0.5 * (corner(mesh, t, c) + corner(mesh, t, (c + 1) % 3));
    const Vec3 beside = 0.9 * middle + 0.1 * corner(mesh, t, (c + 2) % 3);
    const Vec3 inward = -normalized(area_vector_doubled(mesh, mesh.triangles[t]));
    const double width = wall.ahead(beside, inward, triangle);
    if (width < least || length <= kLong * width) continue;
    lengths.limit(edge.key, kParts * width);
    found.add(middle, length);
  }
  if (!is_coarse(mesh, lengths)) return {};
  while (split_once(mesh, lengths) > 0) {
  }
  return found;
}

}  // namespace angio::meshing::detail

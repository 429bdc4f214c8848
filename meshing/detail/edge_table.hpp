#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/triangle_mesh.hpp"

/// What the steps of soup.hpp and sheets.hpp share.
namespace angio::meshing::detail {

using EdgeKey = std::array<int, 2>;
inline EdgeKey edge_key(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

/// Triangles at each edge, as 3 * triangle + first corner of the edge; edges in ascending order.
class EdgeTable {
 public:
  struct Edge {
    EdgeKey key;
    std::span<const int> at;
  };
  explicit EdgeTable(const TriangleMesh& mesh) {
    // In buckets by the lower corner, which have few edges each to sort.
    std::vector<std::size_t> first_of(mesh.vertices.size() + 1, 0);
    const auto for_sides = [&](const auto& take) {
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t c = 0; c < 3; ++c)
          take(edge_key(mesh.triangles[t][c], mesh.triangles[t][(c + 1) % 3]), int(3 * t + c));
    };
    for_sides([&](const EdgeKey& key, int) { ++first_of[std::size_t(key[0]) + 1]; });
    std::partial_sum(first_of.begin(), first_of.end(), first_of.begin());
    std::vector<std::pair<EdgeKey, int>> sides(3 * mesh.triangles.size());
    std::vector<std::size_t> next(first_of.begin(), first_of.end() - 1);
    for_sides([&](const EdgeKey& key, int index) {
      sides[next[std::size_t(key[0])]++] = {key, index};
    });
    for (std::size_t v = 0; v + 1 < first_of.size(); ++v)
      std::sort(sides.begin() + std::ptrdiff_t(first_of[v]),
                sides.begin() + std::ptrdiff_t(first_of[v + 1]));
    at_.reserve(sides.size());
    for (const auto& [key, index] : sides) at_.push_back(index);
    for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
      while (last < sides.size() && sides[last].first == sides[first].first) ++last;
      edges_.push_back({sides[first].first, std::span(at_).subspan(first, last - first)});
    }
  }
  [[nodiscard]] auto begin() const { return edges_.begin(); }
  [[nodiscard]] auto end() const { return edges_.end(); }

 private:
  std::vector<int> at_;
  std::vector<Edge> edges_;
};

/// The first of those that were united with `v`.
inline int find_root(std::vector<int>& parent, int v) {
  while (parent[std::size_t(v)] != v) {
    parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
    v = parent[std::size_t(v)];
  }
  return v;
}
inline void unite(std::vector<int>& parent, int a, int b) {
  a = find_root(parent, a);
  b = find_root(parent, b);
  parent[std::size_t(std::max(a, b))] = std::min(a, b);
}

inline Vec3 corner(const TriangleMesh& mesh, std::size_t t, std::size_t c) {
  return mesh.vertices[std::size_t(mesh.triangles[t][c])];
}

}  // namespace angio::meshing::detail

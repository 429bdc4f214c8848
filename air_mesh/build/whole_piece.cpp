#include "air_mesh/build/whole_piece.hpp"

#include <algorithm>
#include <array>
#include <map>

namespace angio::air_mesh {
namespace {

/// Triangles with two free edges make a border ragged; without them it is smooth.
bool drop_ears(std::vector<Triangle>& triangles) {
  std::map<std::array<int, 2>, int> count;
  const auto edge = [](int a, int b) { return std::array{std::min(a, b), std::max(a, b)}; };
  for (const Triangle& t : triangles)
    for (std::size_t c = 0; c < 3; ++c) ++count[edge(t[c], t[(c + 1) % 3])];
  const std::size_t before = triangles.size();
  std::erase_if(triangles, [&](const Triangle& t) {
    int free_count = 0;
    for (std::size_t c = 0; c < 3; ++c) free_count += count[edge(t[c], t[(c + 1) % 3])] == 1;
    return free_count >= 2;
  });
  return triangles.size() != before;
}

/// Where triangles meet in a vertex only, the smaller fan goes.
bool drop_pinches(std::vector<Triangle>& triangles, std::size_t vertex_count) {
  std::vector<std::vector<int>> around(vertex_count);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int v : triangles[t]) around[std::size_t(v)].push_back(int(t));
  std::vector<char> gone(triangles.size(), 0);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    std::vector<int> rest = around[v];
    std::vector<std::vector<int>> fans;
    while (!rest.empty()) {
      std::vector<int> fan{rest.back()};
      rest.pop_back();
      for (std::size_t i = 0; i < fan.size(); ++i)
        for (std::size_t j = 0; j < rest.size();) {
          int shared = 0;
          for (const int a : triangles[std::size_t(fan[i])])
            for (const int b : triangles[std::size_t(rest[j])]) shared += a == b;
          if (shared < 2) {
            ++j;
            continue;
          }
          fan.push_back(rest[j]);
          rest.erase(rest.begin() + std::ptrdiff_t(j));
        }
      fans.push_back(std::move(fan));
    }
    if (fans.size() < 2) continue;
    std::stable_sort(fans.begin(), fans.end(),
                     [](const auto& a, const auto& b) { return a.size() > b.size(); });
    for (std::size_t f = 1; f < fans.size(); ++f)
      for (const int t : fans[f]) gone[std::size_t(t)] = 1;
  }
  const std::size_t before = triangles.size();
  std::size_t t = 0;
  std::erase_if(triangles, [&](const Triangle&) { return gone[t++] != 0; });
  return triangles.size() != before;
}

/// The connected piece with the most triangles.
void keep_largest_piece(std::vector<Triangle>& triangles, std::size_t vertex_count) {
  std::vector<int> parent(vertex_count);
  for (std::size_t v = 0; v < vertex_count; ++v) parent[v] = int(v);
  const auto root = [&](int v) {
    while (parent[std::size_t(v)] != v)
      v = parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
    return v;
  };
  for (const Triangle& t : triangles)
    for (const int v : {t[1], t[2]}) parent[std::size_t(root(v))] = root(t[0]);
  std::map<int, int> size;
  for (const Triangle& t : triangles) ++size[root(t[0])];
  const auto largest = std::max_element(
      size.begin(), size.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (largest == size.end()) return;
  std::erase_if(triangles, [&](const Triangle& t) { return root(t[0]) != largest->first; });
}

}  // namespace

void make_whole(std::vector<Triangle>& triangles, std::size_t vertex_count) {
  bool changed = true;
  while (changed && !triangles.empty()) {
    changed = drop_ears(triangles);
    changed |= drop_pinches(triangles, vertex_count);
    keep_largest_piece(triangles, vertex_count);
  }
}

}  // namespace angio::air_mesh

#include "simulation/bodies/numbering.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <tuple>

namespace angio::simulation::detail {
namespace {

constexpr int kEnoughColors = 4;

using Neighbors = std::vector<std::vector<int>>;

std::vector<int> breadth_first_rank(const Neighbors& neighbors) {
  std::vector<int> rank(neighbors.size(), -1), queue;
  int next = 0;
  for (std::size_t seed = 0; seed < neighbors.size(); ++seed) {
    if (rank[seed] >= 0) continue;
    queue.assign(1, int(seed));
    rank[seed] = next++;
    for (std::size_t i = 0; i < queue.size(); ++i)
      for (const int n : neighbors[std::size_t(queue[i])])
        if (rank[std::size_t(n)] < 0) {
          rank[std::size_t(n)] = next++;
          queue.push_back(n);
        }
  }
  return rank;
}

int least_free(const std::vector<int>& ring, const std::vector<int>& color) {
  std::vector<char> used(ring.size() + 1, 0);
  for (const int n : ring) {
    const int c = color[std::size_t(n)];
    if (c >= 0 && c < int(used.size())) used[std::size_t(c)] = 1;
  }
  return int(std::find(used.begin(), used.end(), 0) - used.begin());
}

// -1 for vertices that do not move.
std::vector<int> color_vertices(const Neighbors& neighbors, const std::vector<char>& fixed,
                                const std::vector<int>& rank) {
  const std::size_t count = neighbors.size();
  std::vector<int> color(count, -1);
  std::vector<std::set<int>> seen(count);    // colours around a vertex
  std::set<std::tuple<int, int, int>> open;  // -saturation, rank, vertex
  for (std::size_t v = 0; v < count; ++v)
    if (!fixed[v]) open.emplace(0, rank[v], int(v));
  while (!open.empty()) {
    const int v = std::get<2>(*open.begin());
    open.erase(open.begin());
    const int c = least_free(neighbors[std::size_t(v)], color);
    color[std::size_t(v)] = c;
    for (const int n : neighbors[std::size_t(v)]) {
      const auto i = std::size_t(n);
      if (fixed[i] || color[i] >= 0 || seen[i].count(c) > 0) continue;
      open.erase({-int(seen[i].size()), rank[i], n});
      seen[i].insert(c);
      open.emplace(-int(seen[i].size()), rank[i], n);
    }
  }
  return color;
}

// The part of the surface in the colours a and b that hangs together with the vertices given.
std::vector<int> kempe_chain(const Neighbors& neighbors, const std::vector<int>& color,
                             std::vector<int> chain, int a, int b) {
  std::set<int> seen(chain.begin(), chain.end());
  for (std::size_t i = 0; i < chain.size(); ++i)
    for (const int n : neighbors[std::size_t(chain[i])]) {
      const int c = color[std::size_t(n)];
      if ((c == a || c == b) && seen.insert(n).second) chain.push_back(n);
    }
  return chain;
}

// Frees the colour a around v by exchanging a and b in a chain (Kempe 1879); false if the chain
// comes back to v.
bool free_color(const Neighbors& neighbors, int v, int a, int b, std::vector<int>& color) {
  std::vector<int> chain, others;
  for (const int n : neighbors[std::size_t(v)]) {
    if (color[std::size_t(n)] == a) chain.push_back(n);
    if (color[std::size_t(n)] == b) others.push_back(n);
  }
  chain = kempe_chain(neighbors, color, std::move(chain), a, b);
  for (const int other : others)
    if (std::find(chain.begin(), chain.end(), other) != chain.end()) return false;
  for (const int n : chain) color[std::size_t(n)] = a + b - color[std::size_t(n)];
  color[std::size_t(v)] = a;
  return true;
}

// Takes the last colours, of a few vertices, apart: each costs a pass, and four are enough for
// every closed surface without handles.
void drop_small_colors(const Neighbors& neighbors, std::vector<int>& color) {
  for (std::size_t v = 0; v < color.size(); ++v)
    for (int a = 0; a < kEnoughColors && color[v] >= kEnoughColors; ++a)
      for (int b = 0; b < kEnoughColors && color[v] >= kEnoughColors; ++b)
        if (a != b) free_color(neighbors, int(v), a, b, color);
}

std::vector<int> inverse_of(const std::vector<int>& order) {
  std::vector<int> position(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) position[std::size_t(order[i])] = int(i);
  return position;
}

template <class Value>
void reorder(const std::vector<int>& order, std::vector<Value>& values) {
  std::vector<Value> result(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) result[i] = values[std::size_t(order[i])];
  values = std::move(result);
}

void renumber_mesh(const std::vector<int>& order, TriangleMesh& mesh) {
  reorder(order, mesh.vertices);
  const std::vector<int> position = inverse_of(order);
  for (Triangle& t : mesh.triangles)
    for (int& v : t) v = position[std::size_t(v)];
  const auto first = [](const Triangle& t) { return std::min({t[0], t[1], t[2]}); };
  std::stable_sort(mesh.triangles.begin(), mesh.triangles.end(),
                   [&](const Triangle& a, const Triangle& b) { return first(a) < first(b); });
}

}  // namespace

Numbering number_vertices(const TriangleMesh& mesh, const std::vector<char>& fixed,
                          const std::vector<std::array<int, 2>>& partners) {
  Neighbors neighbors = vertex_neighbors(mesh);
  for (const auto& [a, b] : partners) {
    std::vector<int>&of_a = neighbors[std::size_t(a)], &of_b = neighbors[std::size_t(b)];
    if (std::find(of_a.begin(), of_a.end(), b) != of_a.end()) continue;  // once: chains are swapped
    of_a.push_back(b);
    of_b.push_back(a);
  }
  const std::vector<int> rank = breadth_first_rank(neighbors);
  std::vector<int> color = color_vertices(neighbors, fixed, rank);
  drop_small_colors(neighbors, color);
  Numbering numbering;
  numbering.order.resize(mesh.vertices.size());
  std::iota(numbering.order.begin(), numbering.order.end(), 0);
  const auto key = [&](int v) {
    const int c = color[std::size_t(v)];
    return std::pair(c < 0 ? int(color.size()) : c, rank[std::size_t(v)]);
  };
  std::sort(numbering.order.begin(), numbering.order.end(),
            [&](int a, int b) { return key(a) < key(b); });
  const int colors = color.empty() ? 0 : 1 + *std::max_element(color.begin(), color.end());
  numbering.begin.assign(std::size_t(colors) + 1, 0);
  for (const int c : color)
    if (c >= 0) ++numbering.begin[std::size_t(c) + 1];
  std::partial_sum(numbering.begin.begin(), numbering.begin.end(), numbering.begin.begin());
  return numbering;
}

SimulationModel renumbered(const SimulationModel& model, const Numbering& balloon,
                           const Numbering& wall) {
  SimulationModel result = model;
  renumber_mesh(balloon.order, result.balloon);
  reorder(balloon.order, result.balloon_rest);
  reorder(balloon.order, result.balloon_fixed);
  if (!result.balloon_sliding.empty()) reorder(balloon.order, result.balloon_sliding);
  renumber_mesh(wall.order, result.wall);
  reorder(wall.order, result.wall_fixed);
  reorder(wall.order, result.wall_abscissa);
  reorder(wall.order, result.wall_group);
  const std::vector<int> on_balloon = inverse_of(balloon.order), on_wall = inverse_of(wall.order);
  const int first_wall = int(on_balloon.size());
  for (Tet& tet : result.air)
    for (int& v : tet)
      v = v < first_wall ? on_balloon[std::size_t(v)]
                         : first_wall + on_wall[std::size_t(v - first_wall)];
  return result;
}

}  // namespace angio::simulation::detail

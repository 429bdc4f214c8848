#include "core/triangle_mesh.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

namespace angio {
namespace {

/// A directed edge of a triangle under its undirected key.
struct HalfEdge {
  int low, high;
  bool reversed;
  friend bool operator<(const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.reversed) < std::tie(b.low, b.high, b.reversed);
  }
};

std::vector<HalfEdge> sorted_half_edges(const TriangleMesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = t[c];
      const int b = t[(c + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a > b});
    }
  std::sort(edges.begin(), edges.end());
  return edges;
}

int find_root(std::vector<int>& parent, int v) {
  while (parent[std::size_t(v)] != v) {
    parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
    v = parent[std::size_t(v)];
  }
  return v;
}

/// Walks along directed edges until none is left. Where a walk meets itself, the round that it has
/// closed is a loop of its own, so loops that share a vertex come apart.
std::vector<std::vector<int>> take_simple_loops(std::multimap<int, int> next) {
  std::vector<std::vector<int>> loops;
  while (!next.empty()) {
    std::vector<int> walk{next.begin()->first};
    std::map<int, std::size_t> place{{walk.front(), 0}};  // of each vertex in the walk
    for (auto step = next.find(walk.back()); step != next.end(); step = next.find(walk.back())) {
      const int v = step->second;
      next.erase(step);
      const auto [met, is_new] = place.try_emplace(v, walk.size());
      if (is_new) {
        walk.push_back(v);
        continue;
      }
      const auto first = walk.begin() + std::ptrdiff_t(met->second);
      loops.emplace_back(first, walk.end());
      for (auto u = first + 1; u != walk.end(); ++u) place.erase(*u);
      walk.erase(first + 1, walk.end());
    }
  }
  return loops;
}

}  // namespace

Vec3 area_vector_doubled(const TriangleMesh& mesh, const Triangle& triangle) {
  const Vec3& a = mesh.vertices[std::size_t(triangle[0])];
  const Vec3& b = mesh.vertices[std::size_t(triangle[1])];
  const Vec3& c = mesh.vertices[std::size_t(triangle[2])];
  return cross(b - a, c - a);
}

double surface_area(const TriangleMesh& mesh) {
  double area = 0.0;
  for (const Triangle& t : mesh.triangles) area += 0.5 * norm(area_vector_doubled(mesh, t));
  return area;
}

double enclosed_volume(const TriangleMesh& mesh) {
  double six_volumes = 0.0;
  for (const Triangle& t : mesh.triangles)
    six_volumes += dot(mesh.vertices[std::size_t(t[0])],
                       cross(mesh.vertices[std::size_t(t[1])], mesh.vertices[std::size_t(t[2])]));
  return six_volumes / 6.0;
}

std::vector<Vec3> vertex_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    const Vec3 n = area_vector_doubled(mesh, t);
    for (const int v : t) normals[std::size_t(v)] += n;
  }
  for (Vec3& n : normals) n = normalized(n);
  return normals;
}

std::vector<double> vertex_areas(const TriangleMesh& mesh) {
  std::vector<double> areas(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    const double third = norm(area_vector_doubled(mesh, t)) / 6.0;
    for (const int v : t) areas[std::size_t(v)] += third;
  }
  return areas;
}

std::vector<std::array<int, 2>> unique_edges(const TriangleMesh& mesh) {
  std::vector<std::array<int, 2>> edges;
  for (const HalfEdge& e : sorted_half_edges(mesh))
    if (edges.empty() || edges.back() != std::array<int, 2>{e.low, e.high})
      edges.push_back({e.low, e.high});
  return edges;
}

std::vector<std::vector<int>> vertex_neighbors(const TriangleMesh& mesh) {
  std::vector<std::vector<int>> neighbors(mesh.vertices.size());
  for (const auto& [a, b] : unique_edges(mesh)) {
    neighbors[std::size_t(a)].push_back(b);
    neighbors[std::size_t(b)].push_back(a);
  }
  for (auto& list : neighbors) std::sort(list.begin(), list.end());
  return neighbors;
}

std::vector<std::array<int, 3>> triangle_neighbors(const TriangleMesh& mesh) {
  struct Side {
    int low, high, triangle, corner;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const auto [low, high] = std::minmax(mesh.triangles[t][std::size_t(c)],
                                           mesh.triangles[t][std::size_t((c + 1) % 3)]);
      sides.push_back({low, high, int(t), c});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  std::vector<std::array<int, 3>> neighbors(mesh.triangles.size(), {-1, -1, -1});
  for (std::size_t first = 0; first < sides.size();) {
    std::size_t last = first;
    while (last < sides.size() && sides[last].low == sides[first].low &&
           sides[last].high == sides[first].high)
      ++last;
    if (last - first == 2) {
      const Side &a = sides[first], &b = sides[first + 1];
      neighbors[std::size_t(a.triangle)][std::size_t(a.corner)] = b.triangle;
      neighbors[std::size_t(b.triangle)][std::size_t(b.corner)] = a.triangle;
    }
    first = last;
  }
  return neighbors;
}

SurfaceTopology surface_topology(const TriangleMesh& mesh) {
  SurfaceTopology topology;
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<char> used(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) used[std::size_t(v)] = 1;

  const std::vector<HalfEdge> edges = sorted_half_edges(mesh);
  int edge_count = 0;
  for (std::size_t first = 0; first < edges.size();) {
    std::size_t last = first;
    int reversed_count = 0;
    while (last < edges.size() && edges[last].low == edges[first].low &&
           edges[last].high == edges[first].high)
      reversed_count += edges[last++].reversed ? 1 : 0;
    const std::size_t count = last - first;
    if (count == 1) ++topology.boundary_edge_count;
    if (count > 2 || (count == 2 && reversed_count != 1)) ++topology.nonmanifold_edge_count;
    parent[std::size_t(find_root(parent, edges[first].low))] = find_root(parent, edges[first].high);
    ++edge_count;
    first = last;
  }
  int vertex_count = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    ++vertex_count;
    if (find_root(parent, int(v)) == int(v)) ++topology.component_count;
  }
  topology.euler_number = vertex_count - edge_count + int(mesh.triangles.size());
  return topology;
}

std::vector<std::vector<int>> boundary_loops(const TriangleMesh& mesh) {
  const std::vector<HalfEdge> edges = sorted_half_edges(mesh);
  std::multimap<int, int> next;  // along the cap: against the triangles' own direction
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto same = [&](std::size_t other) {
      return other < edges.size() && edges[other].low == edges[e].low &&
             edges[other].high == edges[e].high;
    };
    if (same(e + 1) || (e > 0 && same(e - 1))) continue;
    if (edges[e].reversed)
      next.emplace(edges[e].low, edges[e].high);
    else
      next.emplace(edges[e].high, edges[e].low);
  }
  std::vector<std::vector<int>> loops = take_simple_loops(std::move(next));
  const auto length = [&](const std::vector<int>& loop) {
    double sum = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i)
      sum += distance(mesh.vertices[std::size_t(loop[i])],
                      mesh.vertices[std::size_t(loop[(i + 1) % loop.size()])]);
    return sum;
  };
  std::stable_sort(loops.begin(), loops.end(),
                   [&](const auto& a, const auto& b) { return length(a) > length(b); });
  return loops;
}

}  // namespace angio

#include "meshing/detail/soup.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>
#include <unordered_map>
#include <utility>

#include "core/statistics.hpp"
#include "meshing/detail/edge_table.hpp"

namespace angio::meshing::detail {
namespace {

/// Points in cubic cells, found again by place.
class PointGrid {
 public:
  explicit PointGrid(double cell) : cell_(cell) {}
  void add(const Vec3& p, int index) { cells_[key(at(p))].push_back(index); }
  /// Calls visit(index) for every point in the cells that a box touches.
  void visit(const Vec3& low, const Vec3& high, const auto& visit) const {
    const auto a = at(low);
    const auto b = at(high);
    for (std::int64_t k = a[2]; k <= b[2]; ++k)
      for (std::int64_t j = a[1]; j <= b[1]; ++j)
        for (std::int64_t i = a[0]; i <= b[0]; ++i) {
          const auto found = cells_.find(key({i, j, k}));
          if (found == cells_.end()) continue;
          for (const int index : found->second) visit(index);
        }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  [[nodiscard]] Cell at(const Vec3& p) const {
    return {std::int64_t(std::floor(p.x / cell_)), std::int64_t(std::floor(p.y / cell_)),
            std::int64_t(std::floor(p.z / cell_))};
  }
  static std::uint64_t key(const Cell& c) {  // cells that share a key are looked at in vain only
    return std::uint64_t(c[0]) * 73856093U ^ std::uint64_t(c[1]) * 19349663U ^
           std::uint64_t(c[2]) * 83492791U;
  }
  double cell_;
  std::unordered_map<std::uint64_t, std::vector<int>> cells_;
};

}  // namespace

double median_edge_length(const TriangleMesh& mesh) {
  std::vector<double> lengths;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c)
      lengths.push_back(distance(corner(mesh, t, c), corner(mesh, t, (c + 1) % 3)));
  if (lengths.empty()) return 0.0;
  return median(std::move(lengths));
}

Count merge_points(TriangleMesh& mesh, double tolerance) {
  Count merged;
  PointGrid grid(std::max(4.0 * tolerance, 0.25 * median_edge_length(mesh)));
  std::vector<int> index(mesh.vertices.size(), -1);
  std::vector<char> used(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) used[std::size_t(v)] = 1;
  std::vector<Vec3> kept;
  const Vec3 reach{tolerance, tolerance, tolerance};
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!used[v]) continue;
    const Vec3& p = mesh.vertices[v];
    grid.visit(p - reach, p + reach, [&](int other) {
      if (index[v] < 0 && distance(kept[std::size_t(other)], p) <= tolerance) index[v] = other;
    });
    if (index[v] >= 0) {
      merged.add(p);
      continue;
    }
    index[v] = int(kept.size());
    grid.add(p, index[v]);
    kept.push_back(p);
  }
  for (Triangle& t : mesh.triangles)
    for (int& v : t) v = index[std::size_t(v)];
  mesh.vertices = std::move(kept);
  return merged;
}

Count drop_degenerate(TriangleMesh& mesh, double tolerance) {
  Count dropped;
  std::vector<Triangle> kept;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[std::size_t(t[0])];
    const Vec3& b = mesh.vertices[std::size_t(t[1])];
    const Vec3& c = mesh.vertices[std::size_t(t[2])];
    const double longest = std::max({distance(a, b), distance(b, c), distance(c, a)});
    const bool repeats = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    const bool is_flat = norm(cross(b - a, c - a)) <= tolerance * longest;
    if (repeats || is_flat)
      dropped.add(a);
    else
      kept.push_back(t);
  }
  mesh.triangles = std::move(kept);
  return dropped;
}

Count drop_duplicates(TriangleMesh& mesh) {
  Count dropped;
  std::set<Triangle> seen;
  std::vector<Triangle> kept;
  for (const Triangle& t : mesh.triangles) {
    Triangle key = t;
    std::sort(key.begin(), key.end());
    if (seen.insert(key).second)
      kept.push_back(t);
    else
      dropped.add(mesh.vertices[std::size_t(t[0])]);
  }
  mesh.triangles = std::move(kept);
  return dropped;
}

Count join_t_junctions(TriangleMesh& mesh, double tolerance) {
  Count joined;
  constexpr int kRounds = 3;  // a triangle is split at one of its edges a round
  for (int round = 0; round < kRounds; ++round) {
    PointGrid grid(std::max(median_edge_length(mesh), tolerance));
    std::set<int> border;
    std::vector<std::array<std::size_t, 2>> open;  // triangle and first corner
    const EdgeTable edges(mesh);
    for (const auto& [key, at] : edges) {
      if (at.size() != 1) continue;
      open.push_back({std::size_t(at[0]) / 3, std::size_t(at[0]) % 3});
      border.insert(key.begin(), key.end());
    }
    for (const int v : border) grid.add(mesh.vertices[std::size_t(v)], v);
    std::set<std::size_t> split;
    const Vec3 reach{tolerance, tolerance, tolerance};
    for (const auto& [t, c] : open) {
      if (split.contains(t)) continue;
      const Triangle whole = mesh.triangles[t];
      const Vec3 a = corner(mesh, t, c);
      const Vec3 b = corner(mesh, t, (c + 1) % 3);
      const double length = distance(a, b);
      std::vector<std::pair<double, int>> on_edge;
      const Vec3 low{std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
      const Vec3 high{std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
      grid.visit(low - reach, high + reach, [&](int v) {
        if (v == whole[0] || v == whole[1] || v == whole[2]) return;
        const Vec3& p = mesh.vertices[std::size_t(v)];
        const double s = dot(p - a, b - a) / (length * length);
        if (s * length > tolerance && (1.0 - s) * length > tolerance &&
            distance(p, a + s * (b - a)) <= tolerance)
          on_edge.emplace_back(s, v);
      });
      if (on_edge.empty()) continue;
      std::sort(on_edge.begin(), on_edge.end());
      on_edge.erase(std::unique(on_edge.begin(), on_edge.end()), on_edge.end());
      split.insert(t);
      int from = whole[c];
      const int tip = whole[(c + 2) % 3];
      for (const auto& [s, v] : on_edge) {
        mesh.triangles.push_back({from, v, tip});
        joined.add(mesh.vertices[std::size_t(v)]);
        from = v;
      }
      mesh.triangles[t] = {from, whole[(c + 1) % 3], tip};
    }
    if (split.empty()) break;
  }
  return joined;
}

std::vector<int> vertex_components(const TriangleMesh& mesh) {
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const Triangle& t : mesh.triangles) {
    unite(parent, t[0], t[1]);
    unite(parent, t[0], t[2]);
  }
  for (std::size_t v = 0; v < parent.size(); ++v) parent[v] = find_root(parent, int(v));
  return parent;
}

TriangleMesh part_of(const TriangleMesh& mesh, const std::vector<char>& keep) {
  TriangleMesh part;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!keep[t]) continue;
    Triangle renamed{};
    for (std::size_t c = 0; c < 3; ++c) {
      int& at = index[std::size_t(mesh.triangles[t][c])];
      if (at < 0) {
        at = int(part.vertices.size());
        part.vertices.push_back(corner(mesh, t, c));
      }
      renamed[c] = at;
    }
    part.triangles.push_back(renamed);
  }
  return part;
}

}  // namespace angio::meshing::detail

#include "meshing/detail/soup.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>

#include "core/error.hpp"
#include "core/statistics.hpp"

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

using EdgeKey = std::array<int, 2>;
EdgeKey edge_key(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

/// Triangles at each edge, as 3 * triangle + first corner of the edge; edges in ascending order.
class EdgeTable {
 public:
  struct Edge {
    EdgeKey key;
    std::span<const int> at;
  };
  explicit EdgeTable(const TriangleMesh& mesh) {
    std::vector<std::pair<EdgeKey, int>> sides;
    sides.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c)
        sides.emplace_back(edge_key(mesh.triangles[t][c], mesh.triangles[t][(c + 1) % 3]),
                           int(3 * t + c));
    std::sort(sides.begin(), sides.end());
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

int find_root(std::vector<int>& parent, int v) {
  while (parent[std::size_t(v)] != v) {
    parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
    v = parent[std::size_t(v)];
  }
  return v;
}
void unite(std::vector<int>& parent, int a, int b) {
  a = find_root(parent, a);
  b = find_root(parent, b);
  parent[std::size_t(std::max(a, b))] = std::min(a, b);
}

Vec3 corner(const TriangleMesh& mesh, std::size_t t, std::size_t c) {
  return mesh.vertices[std::size_t(mesh.triangles[t][c])];
}

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

Count cut_off_fins(TriangleMesh& mesh) {
  Count cut;
  constexpr double kLargest = 0.2;  // of the area; what is larger is no fin
  constexpr int kRounds = 1000;
  for (int round = 0; round < kRounds; ++round) {
    const EdgeTable edges(mesh);
    std::vector<int> parent(mesh.triangles.size());
    std::iota(parent.begin(), parent.end(), 0);
    for (const auto& [key, at] : edges)
      if (at.size() == 2) unite(parent, at[0] / 3, at[1] / 3);
    std::map<int, double> area;
    double whole = 0.0;
    for (std::size_t t = 0; t < parent.size(); ++t) {
      const double own = norm(area_vector_doubled(mesh, mesh.triangles[t]));
      area[find_root(parent, int(t))] += own;
      whole += own;
    }
    std::set<int> free;
    std::set<int> meets;
    for (const auto& [key, at] : edges)
      for (const int i : at) {
        if (at.size() == 1) free.insert(find_root(parent, i / 3));
        if (at.size() > 2) meets.insert(find_root(parent, i / 3));
      }
    int fin = -1;
    for (const int sheet : meets)
      if (free.contains(sheet) && area[sheet] < kLargest * whole &&
          (fin < 0 || area[sheet] < area[fin]))
        fin = sheet;
    // A wall between two lumens, without a free border: the smallest sheet at an odd edge.
    for (const auto& [key, at] : edges) {
      if (fin >= 0 && free.contains(fin)) break;
      if (at.size() <= 2 || at.size() % 2 == 0) continue;
      for (const int i : at) {
        const int sheet = find_root(parent, i / 3);
        if (area[sheet] < kLargest * whole && (fin < 0 || area[sheet] < area[fin])) fin = sheet;
      }
    }
    if (fin < 0) break;
    std::vector<Triangle> kept;
    for (std::size_t t = 0; t < parent.size(); ++t) {
      if (find_root(parent, int(t)) == fin)
        cut.add(corner(mesh, t, 0));
      else
        kept.push_back(mesh.triangles[t]);
    }
    mesh.triangles = std::move(kept);
  }
  return cut;
}

Count turn_alike(TriangleMesh& mesh) {
  const EdgeTable edges(mesh);
  std::vector<std::vector<std::pair<int, bool>>> next(
      mesh.triangles.size());  // and: same way round
  for (const auto& [key, at] : edges) {
    if (at.size() != 2) continue;
    const auto first = [&](int i) {
      return mesh.triangles[std::size_t(i / 3)][std::size_t(i % 3)];
    };
    const bool alike = first(at[0]) != first(at[1]);
    next[std::size_t(at[0] / 3)].emplace_back(at[1] / 3, alike);
    next[std::size_t(at[1] / 3)].emplace_back(at[0] / 3, alike);
  }
  std::vector<int> turned(mesh.triangles.size(), -1);
  Count count;
  for (std::size_t seed = 0; seed < turned.size(); ++seed) {
    if (turned[seed] >= 0) continue;
    std::vector<int> sheet{int(seed)};
    turned[seed] = 0;
    std::size_t turned_count = 0;
    for (std::size_t i = 0; i < sheet.size(); ++i)
      for (const auto& [t, alike] : next[std::size_t(sheet[i])]) {
        const int wanted =
            alike ? turned[std::size_t(sheet[i])] : 1 - turned[std::size_t(sheet[i])];
        int& own = turned[std::size_t(t)];
        if (own < 0) {
          own = wanted;
          turned_count += std::size_t(wanted);
          sheet.push_back(t);
        } else if (own != wanted) {
          throw InputError(
              "the surface is one-sided, like a Moebius strip (it has no inside). Cut it open "
              "where "
              "it is twisted, or segment again");
        }
      }
    const int minority = 2 * turned_count > sheet.size() ? 0 : 1;
    for (const int t : sheet) {
      if (turned[std::size_t(t)] != minority) continue;
      std::swap(mesh.triangles[std::size_t(t)][1], mesh.triangles[std::size_t(t)][2]);
      count.add(corner(mesh, std::size_t(t), 0));
    }
  }
  return count;
}

Count take_sheets_apart(TriangleMesh& mesh) {
  std::vector<int> parent(3 * mesh.triangles.size());  // of corners
  std::iota(parent.begin(), parent.end(), 0);
  const auto join = [&](int i, int j) {  // the two sides run against each other
    unite(parent, i, j / 3 * 3 + (j % 3 + 1) % 3);
    unite(parent, i / 3 * 3 + (i % 3 + 1) % 3, j);
  };
  const EdgeTable edges(mesh);
  for (const auto& [key, at] : edges) {
    const Vec3& a = mesh.vertices[std::size_t(key[0])];
    const Vec3 along = normalized(mesh.vertices[std::size_t(key[1])] - a);
    const Vec3 u = any_perpendicular(along);
    const Vec3 v = cross(along, u);
    struct Side {
      double angle;
      int index;
      bool forward;
    };
    std::vector<Side> sides;
    for (const int i : at) {
      const auto t = std::size_t(i / 3);
      const Vec3 out = corner(mesh, t, std::size_t((i + 2 - (i / 3) * 3) % 3)) - a;
      sides.push_back({std::atan2(dot(out, v), dot(out, u)), i,
                       mesh.triangles[t][std::size_t(i % 3)] == key[0]});
    }
    std::stable_sort(sides.begin(), sides.end(),
                     [](const Side& x, const Side& y) { return x.angle < y.angle; });
    // Going round the edge, the inside begins behind a forward triangle's back.
    const std::size_t n = sides.size();
    for (std::size_t i = 0; i < n && n > 1; ++i) {
      const Side& side = sides[i];
      const Side& other = sides[(i + n - 1) % n];
      if (n == 2 ? (i == 0 && side.forward != other.forward) : (side.forward && !other.forward))
        join(side.index, other.index);
    }
  }
  Count copies;
  std::map<int, int> vertex_of;  // of a class of corners
  std::vector<char> taken(mesh.vertices.size(), 0);
  std::vector<Triangle> triangles = mesh.triangles;
  for (std::size_t i = 0; i < parent.size(); ++i) {
    const int old_vertex = mesh.triangles[i / 3][i % 3];
    const auto [at, is_new] = vertex_of.try_emplace(find_root(parent, int(i)), old_vertex);
    if (is_new && taken[std::size_t(old_vertex)]) {
      at->second = int(mesh.vertices.size());
      mesh.vertices.push_back(Vec3(mesh.vertices[std::size_t(old_vertex)]));
      copies.add(mesh.vertices.back());
    }
    if (is_new) taken[std::size_t(old_vertex)] = 1;
    triangles[i / 3][i % 3] = at->second;
  }
  mesh.triangles = std::move(triangles);
  return copies;
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

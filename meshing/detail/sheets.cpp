#include "meshing/detail/sheets.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "meshing/detail/edge_table.hpp"

namespace angio::meshing::detail {

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

namespace {

/// Of the triangles' sides at an edge, the pairs that stay together: those between which the inside
/// lies.
std::vector<std::array<int, 2>> pairs_at(const TriangleMesh& mesh, const EdgeTable::Edge& edge) {
  const Vec3& a = mesh.vertices[std::size_t(edge.key[0])];
  const Vec3 along = normalized(mesh.vertices[std::size_t(edge.key[1])] - a);
  const Vec3 u = any_perpendicular(along);
  const Vec3 v = cross(along, u);
  struct Side {
    double angle;
    int index;
    bool forward;
  };
  std::vector<Side> sides;
  for (const int i : edge.at) {
    const auto t = std::size_t(i / 3);
    const Vec3 out = corner(mesh, t, std::size_t((i + 2 - (i / 3) * 3) % 3)) - a;
    sides.push_back({std::atan2(dot(out, v), dot(out, u)), i,
                     mesh.triangles[t][std::size_t(i % 3)] == edge.key[0]});
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& x, const Side& y) { return x.angle < y.angle; });
  // Going round the edge, the inside begins behind a forward triangle's back.
  std::vector<std::array<int, 2>> pairs;
  const std::size_t n = sides.size();
  for (std::size_t i = 0; i < n && n > 1; ++i) {
    const Side& side = sides[i];
    const Side& other = sides[(i + n - 1) % n];
    if (n == 2 ? (i == 0 && side.forward != other.forward) : (side.forward && !other.forward))
      pairs.push_back({side.index, other.index});
  }
  return pairs;
}

/// Gives every class of corners a vertex of its own.
/// @param parent  of corners, see find_root
Count separate_corners(TriangleMesh& mesh, std::vector<int>& parent) {
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

/// The sides at an edge in groups that stay together: pairs_at's pairs, and alone each side that
/// has no other (an odd number of sheets meets there, or two that are turned the same way).
std::vector<std::vector<int>> groups_at(const TriangleMesh& mesh, const EdgeTable::Edge& edge) {
  std::vector<std::vector<int>> groups;
  std::set<int> alone(edge.at.begin(), edge.at.end());
  for (const auto& [i, j] : pairs_at(mesh, edge)) {
    groups.push_back({i, j});
    alone.erase(i);
    alone.erase(j);
  }
  for (const int i : alone) groups.push_back({i});
  return groups;
}

/// Halves the edges of groups of triangles until no two groups have the same corners at their edge:
/// sheets that meet in an edge may hang together at both its ends, so that no corner comes apart.
void halve_shared_edges(TriangleMesh& mesh, Count& halved) {
  constexpr int kRounds = 100;  // two triangles that coincide are halved for ever
  bool any = true;
  for (int round = 0; any && round < kRounds; ++round) {
    any = false;
    std::vector<std::vector<int>> groups;
    for (const EdgeTable edges(mesh); const EdgeTable::Edge& edge : edges) {
      if (edge.at.size() <= 2) continue;
      const auto own = groups_at(mesh, edge);
      groups.insert(groups.end(), own.begin() + 1, own.end());
    }
    std::vector<char> is_halved(mesh.triangles.size(), 0);  // a triangle's next edge has to wait
    for (const std::vector<int>& group : groups) {
      if (std::any_of(group.begin(), group.end(),
                      [&](int side) { return is_halved[std::size_t(side / 3)]; }))
        continue;
      const int middle = int(mesh.vertices.size());
      const auto t = std::size_t(group[0] / 3), first = std::size_t(group[0] % 3);
      mesh.vertices.push_back(0.5 * (corner(mesh, t, first) + corner(mesh, t, (first + 1) % 3)));
      for (const int side : group) {
        is_halved[std::size_t(side / 3)] = 1;
        Triangle& one = mesh.triangles[std::size_t(side / 3)];
        Triangle other = one;
        one[std::size_t(side % 3 + 1) % 3] = other[std::size_t(side % 3)] = middle;
        mesh.triangles.push_back(other);
      }
      halved.add(mesh.vertices.back());
      any = true;
    }
  }
}

}  // namespace

Count take_sheets_apart(TriangleMesh& mesh) {
  std::vector<int> parent(3 * mesh.triangles.size());  // of corners
  std::iota(parent.begin(), parent.end(), 0);
  for (const EdgeTable edges(mesh); const EdgeTable::Edge& edge : edges)
    for (const auto& [i, j] : pairs_at(mesh, edge)) {  // the two sides run against each other
      unite(parent, i, j / 3 * 3 + (j % 3 + 1) % 3);
      unite(parent, i / 3 * 3 + (i % 3 + 1) % 3, j);
    }
  Count apart = separate_corners(mesh, parent);
  halve_shared_edges(mesh, apart);
  return apart;
}

}  // namespace angio::meshing::detail

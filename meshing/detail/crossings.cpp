#include "meshing/detail/crossings.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "meshing/detail/fill_hole.hpp"
#include "meshing/detail/surface_query.hpp"

namespace angio::meshing::detail {
namespace {

std::vector<std::vector<int>> triangles_around(const TriangleMesh& mesh,
                                               const std::vector<char>& gone) {
  std::vector<std::vector<int>> around(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (!gone[t])
      for (const int v : mesh.triangles[t]) around[std::size_t(v)].push_back(int(t));
  return around;
}

/// Do a vertex's triangles form one fan? They do if all but one pair of neighbours are linked.
bool is_one_fan(const TriangleMesh& mesh, int v, const std::vector<int>& triangles) {
  if (triangles.empty()) return true;
  std::vector<char> reached(triangles.size(), 0);
  std::vector<std::size_t> stack{0};
  reached[0] = 1;
  std::size_t count = 1;
  while (!stack.empty()) {
    const Triangle& t = mesh.triangles[std::size_t(triangles[stack.back()])];
    stack.pop_back();
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (reached[i]) continue;
      const Triangle& other = mesh.triangles[std::size_t(triangles[i])];
      bool linked = false;
      for (const int a : t)
        for (const int b : other) linked |= a == b && a != v;
      if (!linked) continue;
      reached[i] = 1;
      ++count;
      stack.push_back(i);
    }
  }
  return count == triangles.size();
}

/// Triangles within some rings of vertices around crossing ones; rims stay.
std::vector<char> triangles_to_cut(const SurfaceDraft& draft,
                                   const std::vector<std::array<int, 2>>& pairs, int ring_count) {
  const TriangleMesh& mesh = draft.mesh;
  std::vector<char> near(mesh.vertices.size(), 0);
  for (const auto& pair : pairs)
    for (const int t : pair)
      for (const int v : mesh.triangles[std::size_t(t)]) near[std::size_t(v)] = 1;
  const auto grow = [&] {
    const std::vector<char> before = near;
    for (const Triangle& t : mesh.triangles)
      for (const int v : t)
        if (before[std::size_t(v)])
          for (const int u : t) near[std::size_t(u)] = 1;
  };
  for (int ring = 1; ring < ring_count; ++ring) grow();
  std::vector<char> gone(mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    bool cut = false;
    bool at_rim = false;
    for (const int v : mesh.triangles[t]) {
      cut |= near[std::size_t(v)] != 0;
      at_rim |= draft.rim[std::size_t(v)] >= 0;
    }
    gone[t] = cut && !at_rim;
  }
  // A hole's border must not meet itself in a vertex.
  for (bool changed = true; changed;) {
    changed = false;
    const auto around = triangles_around(mesh, gone);
    for (std::size_t v = 0; v < around.size(); ++v) {
      if (is_one_fan(mesh, int(v), around[v])) continue;
      changed = true;
      for (const int t : around[v]) gone[std::size_t(t)] = 1;
    }
  }
  return gone;
}

/// Marks the triangles outside the largest connected piece as gone as well.
void keep_largest_piece(const TriangleMesh& mesh, std::vector<char>& gone) {
  const auto around = triangles_around(mesh, gone);
  std::vector<int> piece(mesh.triangles.size(), -1);
  std::vector<double> area;
  for (std::size_t first = 0; first < mesh.triangles.size(); ++first) {
    if (gone[first] || piece[first] >= 0) continue;
    std::vector<int> stack{int(first)};
    piece[first] = int(area.size());
    double sum = 0.0;
    while (!stack.empty()) {
      const Triangle& t = mesh.triangles[std::size_t(stack.back())];
      stack.pop_back();
      sum += norm(area_vector_doubled(mesh, t));
      for (const int v : t)
        for (const int next : around[std::size_t(v)]) {
          if (piece[std::size_t(next)] >= 0) continue;
          piece[std::size_t(next)] = int(area.size());
          stack.push_back(next);
        }
    }
    area.push_back(sum);
  }
  const auto largest = int(std::max_element(area.begin(), area.end()) - area.begin());
  for (std::size_t t = 0; t < gone.size(); ++t)
    if (!gone[t] && piece[t] != largest) gone[t] = 1;
}

/// The draft without some triangles and the vertices that only they used.
void remove_triangles(SurfaceDraft& draft, const std::vector<char>& gone) {
  SurfaceDraft rest;
  rest.rim_planes = draft.rim_planes;
  std::vector<int> index(draft.mesh.vertices.size(), -1);
  for (std::size_t t = 0; t < gone.size(); ++t) {
    if (gone[t]) continue;
    Triangle renamed{};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto v = std::size_t(draft.mesh.triangles[t][c]);
      if (index[v] < 0) {
        index[v] = int(rest.mesh.vertices.size());
        rest.mesh.vertices.push_back(draft.mesh.vertices[v]);
        rest.edge_length.push_back(draft.edge_length[v]);
        rest.rim.push_back(draft.rim[v]);
      }
      renamed[c] = index[v];
    }
    rest.mesh.triangles.push_back(renamed);
  }
  draft = std::move(rest);
}

/// Closes every hole that is no rim by a membrane. @return number of holes
int close_holes(SurfaceDraft& draft) {
  std::vector<char> loose(draft.mesh.vertices.size(), 0);
  int count = 0;
  for (const std::vector<int>& loop : boundary_loops(draft.mesh)) {
    const auto on_rim = [&](int v) { return draft.rim[std::size_t(v)] >= 0; };
    if (std::all_of(loop.begin(), loop.end(), on_rim)) continue;
    if (std::any_of(loop.begin(), loop.end(), on_rim))
      throw InternalError(
          "the lumen's surface crosses itself at an open end. Cut the vessel "
          "elsewhere or smooth the segmentation there");
    fill_hole(draft.mesh, loop);
    if (draft.mesh.vertices.size() > draft.rim.size()) {
      draft.rim.push_back(-1);
      draft.edge_length.push_back(draft.edge_length[std::size_t(loop.front())]);
      loose.push_back(1);
    }
    for (const int v : loop) loose[std::size_t(v)] = 1;
    ++count;
  }
  constexpr int kRounds = 3;
  remesh_membrane(draft, loose, kRounds);
  return count;
}

}  // namespace

int resolve_crossings(SurfaceDraft& draft) {
  constexpr int kAttempts = 8;
  int closed_count = 0;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto pairs = self_intersections(draft.mesh);
    if (pairs.empty()) return closed_count;
    std::vector<char> gone = triangles_to_cut(draft, pairs, 1 + attempt);
    keep_largest_piece(draft.mesh, gone);
    remove_triangles(draft, gone);
    closed_count += close_holes(draft);
  }
  const std::size_t left = self_intersections(draft.mesh).size();
  if (left == 0) return closed_count;
  throw InternalError("the lumen's surface still crosses itself (" + std::to_string(left) +
                      " pairs of triangles; vessels that touch each other, or noise). Smooth the "
                      "segmentation, or mesh with shorter edges (meshing.edges_per_circumference)");
}

}  // namespace angio::meshing::detail

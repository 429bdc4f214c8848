#include "meshing/detail/patch.hpp"

#include <algorithm>

namespace angio::meshing::detail {
namespace {

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

}  // namespace

std::vector<char> vertices_of_several_fans(const TriangleMesh& mesh,
                                           const std::vector<char>& kept) {
  // Only where kept and other triangles meet can a fan be broken.
  std::vector<char> has_kept(mesh.vertices.size(), 0);
  std::vector<char> has_other(mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int v : mesh.triangles[t]) (kept[t] ? has_kept : has_other)[std::size_t(v)] = 1;
  std::vector<std::vector<int>> around(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (kept[t])
      for (const int v : mesh.triangles[t])
        if (has_other[std::size_t(v)]) around[std::size_t(v)].push_back(int(t));
  std::vector<char> broken(mesh.vertices.size(), 0);
  for (std::size_t v = 0; v < broken.size(); ++v)
    if (has_kept[v] && has_other[v]) broken[v] = is_one_fan(mesh, int(v), around[v]) ? 0 : 1;
  return broken;
}

std::vector<char> mark_corners(const TriangleMesh& mesh,
                               const std::vector<std::array<int, 2>>& triangle_pairs) {
  std::vector<char> marked(mesh.vertices.size(), 0);
  for (const auto& pair : triangle_pairs)
    for (const int t : pair)
      for (const int v : mesh.triangles[std::size_t(t)]) marked[std::size_t(v)] = 1;
  return marked;
}

void grow(const TriangleMesh& mesh, std::vector<char>& marked, int ring_count) {
  for (int ring = 0; ring < ring_count; ++ring) {
    const std::vector<char> before = marked;
    for (const Triangle& t : mesh.triangles)
      if (before[std::size_t(t[0])] || before[std::size_t(t[1])] || before[std::size_t(t[2])])
        for (const int v : t) marked[std::size_t(v)] = 1;
  }
}

Patch take_patch(const SurfaceDraft& whole, const std::vector<char>& marked, int ring_count) {
  Patch patch;
  const TriangleMesh& mesh = whole.mesh;
  std::vector<char> near = marked;
  grow(mesh, near, ring_count - 1);
  patch.in_patch.assign(mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int v : mesh.triangles[t]) patch.in_patch[t] |= near[std::size_t(v)];
  for (bool changed = true; changed;) {  // a patch must not meet itself in a vertex
    changed = false;
    const std::vector<char> broken = vertices_of_several_fans(mesh, patch.in_patch);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (const int v : mesh.triangles[t])
        if (broken[std::size_t(v)] && !patch.in_patch[t]) {
          patch.in_patch[t] = 1;
          changed = true;
        }
  }
  std::vector<char> shared(mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (!patch.in_patch[t])
      for (const int v : mesh.triangles[t]) shared[std::size_t(v)] = 1;
  patch.draft.rim_planes = whole.rim_planes;
  patch.draft.widening = whole.widening;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!patch.in_patch[t]) continue;
    Triangle renamed{};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto v = std::size_t(mesh.triangles[t][c]);
      if (index[v] < 0) {
        index[v] = int(patch.draft.mesh.vertices.size());
        patch.draft.mesh.vertices.push_back(mesh.vertices[v]);
        patch.draft.edge_length.push_back(whole.edge_length[v]);
        patch.draft.rim.push_back(whole.rim[v]);
        patch.draft.membrane.push_back(whole.membrane.empty() ? char(0) : whole.membrane[v]);
        patch.draft.origin.push_back(int(v));
        patch.free.push_back(shared[v] ? 0 : 1);
      }
      renamed[c] = index[v];
    }
    patch.draft.mesh.triangles.push_back(renamed);
  }
  return patch;
}

std::vector<char> put_back(SurfaceDraft& whole, const Patch& patch) {
  SurfaceDraft result;
  result.rim_planes = std::move(whole.rim_planes);
  result.widening = whole.widening;
  whole.membrane.resize(whole.mesh.vertices.size(), 0);
  std::vector<char> is_new;
  std::vector<int> index(whole.mesh.vertices.size(), -1);
  const auto add = [&](const SurfaceDraft& from, std::size_t v) {
    result.mesh.vertices.push_back(from.mesh.vertices[v]);
    result.edge_length.push_back(from.edge_length[v]);
    result.rim.push_back(from.rim[v]);
    result.membrane.push_back(from.membrane[v]);
    return int(result.mesh.vertices.size()) - 1;
  };
  for (std::size_t t = 0; t < whole.mesh.triangles.size(); ++t) {
    if (patch.in_patch[t]) continue;
    Triangle renamed{};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto v = std::size_t(whole.mesh.triangles[t][c]);
      if (index[v] < 0) index[v] = add(whole, v);
      renamed[c] = index[v];
    }
    result.mesh.triangles.push_back(renamed);
    is_new.push_back(0);
  }
  std::vector<int> patch_index(patch.draft.mesh.vertices.size(), -1);
  for (std::size_t v = 0; v < patch_index.size(); ++v) {
    const int origin = patch.draft.origin[v];
    const bool is_tied = origin >= 0 && index[std::size_t(origin)] >= 0;
    patch_index[v] = is_tied ? index[std::size_t(origin)] : add(patch.draft, v);
  }
  for (const Triangle& t : patch.draft.mesh.triangles) {
    result.mesh.triangles.push_back({patch_index[std::size_t(t[0])], patch_index[std::size_t(t[1])],
                                     patch_index[std::size_t(t[2])]});
    is_new.push_back(1);
  }
  whole = std::move(result);
  return is_new;
}

}  // namespace angio::meshing::detail

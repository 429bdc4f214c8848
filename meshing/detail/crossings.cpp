#include "meshing/detail/crossings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "air_mesh/build/surface_crossings.hpp"
#include "core/error.hpp"
#include "meshing/detail/cap_rims.hpp"
#include "meshing/detail/edge_lengths.hpp"
#include "meshing/detail/fill_hole.hpp"
#include "meshing/detail/open_ends.hpp"
#include "meshing/detail/patch.hpp"
#include "meshing/detail/soup.hpp"
#include "meshing/detail/surface_query.hpp"

namespace angio::meshing::detail {
namespace {

using Pairs = std::vector<std::array<int, 2>>;

/// What has to be mended: crossing triangles and sharp folds, with one of the marked triangles.
Pairs find_faults(const TriangleMesh& mesh, const std::vector<char>& marked) {
  Pairs pairs = air_mesh::self_intersections_of(mesh, marked);
  const Pairs folds = sharp_folds_of(mesh, marked);
  pairs.insert(pairs.end(), folds.begin(), folds.end());
  return pairs;
}

/// A rim with crossing triangles is given up: its vertices are of the wall from now on.
void give_up_rims(SurfaceDraft& draft, const Pairs& pairs) {
  std::vector<char> given_up(draft.rim_planes.size(), 0);
  for (const auto& pair : pairs)
    for (const int t : pair)
      for (const int v : draft.mesh.triangles[std::size_t(t)])
        if (draft.rim[std::size_t(v)] >= 0) given_up[std::size_t(draft.rim[std::size_t(v)])] = 1;
  for (int& rim : draft.rim)
    if (rim >= 0 && given_up[std::size_t(rim)]) rim = -1;
}

/// Triangles within some rings of vertices around crossing ones; those at rims stay.
std::vector<char> triangles_to_cut(const SurfaceDraft& draft, const Pairs& pairs, int ring_count) {
  const TriangleMesh& mesh = draft.mesh;
  std::vector<char> near = mark_corners(mesh, pairs);
  grow(mesh, near, ring_count - 1);
  std::vector<char> kept(mesh.triangles.size(), 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    bool cut = false;
    bool at_rim = false;
    for (const int v : mesh.triangles[t]) {
      cut |= near[std::size_t(v)] != 0;
      at_rim |= draft.rim[std::size_t(v)] >= 0;
    }
    kept[t] = !cut || at_rim;
  }
  for (bool changed = true; changed;) {  // a hole's border must not meet itself in a vertex
    changed = false;
    const std::vector<char> broken = vertices_of_several_fans(mesh, kept);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (const int v : mesh.triangles[t])
        if (broken[std::size_t(v)] && kept[t]) {
          kept[t] = 0;
          changed = true;
        }
  }
  std::vector<char> gone(kept.size());
  for (std::size_t t = 0; t < kept.size(); ++t) gone[t] = !kept[t];
  return gone;
}

/// Of each vessel, marks the triangles outside the largest piece that is left as gone as well.
void keep_largest_pieces(const TriangleMesh& mesh, std::vector<char>& gone) {
  std::vector<std::vector<int>> around(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (!gone[t])
      for (const int v : mesh.triangles[t]) around[std::size_t(v)].push_back(int(t));
  std::vector<int> piece(mesh.triangles.size(), -1);
  std::vector<double> area;
  const std::vector<int> vessel = vertex_components(mesh);
  const auto vessel_of = [&](std::size_t t) { return vessel[std::size_t(mesh.triangles[t][0])]; };
  std::map<int, int> largest;  // piece of each vessel
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
    const auto [known, is_new] = largest.try_emplace(vessel_of(first), piece[first]);
    if (!is_new && sum > area[std::size_t(known->second)]) known->second = piece[first];
  }
  for (std::size_t t = 0; t < gone.size(); ++t)
    if (!gone[t] && piece[t] != largest.at(vessel_of(t))) gone[t] = 1;
}

/// The draft without some triangles and the vertices that only they used.
void remove_triangles(SurfaceDraft& draft, const std::vector<char>& gone) {
  SurfaceDraft rest;
  rest.rim_planes = draft.rim_planes;
  rest.widening = draft.widening;
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
        rest.membrane.push_back(draft.membrane[v]);
      }
      renamed[c] = index[v];
    }
    rest.mesh.triangles.push_back(renamed);
  }
  draft = std::move(rest);
}

struct Closed {
  int count = 0;              ///< holes
  std::vector<char> changed;  ///< per triangle
};
/// Closes every hole that is no rim by a membrane.
Closed close_holes(SurfaceDraft& draft) {
  constexpr int kRings = 2;
  constexpr int kRounds = 3;
  int count = 0;
  std::vector<char> loose(draft.mesh.vertices.size(), 0);
  for (const std::vector<int>& loop : boundary_loops(draft.mesh)) {
    const auto on_rim = [&](int v) { return draft.rim[std::size_t(v)] >= 0; };
    if (std::all_of(loop.begin(), loop.end(), on_rim)) continue;
    fill_hole(draft.mesh, loop);
    if (draft.mesh.vertices.size() > draft.rim.size()) {
      draft.rim.push_back(-1);
      draft.membrane.push_back(1);
      draft.edge_length.push_back(draft.edge_length[std::size_t(loop.front())]);
      loose.push_back(1);
    }
    for (const int v : loop) {
      loose[std::size_t(v)] = 1;
      draft.membrane[std::size_t(v)] = 1;
    }
    ++count;
  }
  Patch patch = take_patch(draft, loose, kRings);
  if (patch.empty()) return {count, std::vector<char>(draft.mesh.triangles.size(), 0)};
  for (std::size_t v = 0; v < patch.free.size(); ++v)
    patch.free[v] = patch.free[v] && loose[std::size_t(patch.draft.origin[v])];
  remesh_membrane(patch.draft, patch.free, kRounds);
  return {count, put_back(draft, patch)};
}

/// Remeshes around crossing triangles. @return the pairs that are left
Pairs remesh_crossings(SurfaceDraft& draft, const SurfaceTarget& target, const Pairs& pairs) {
  constexpr int kRings = 5;
  constexpr int kRounds = 3;
  Patch patch = take_patch(draft, mark_corners(draft.mesh, pairs), kRings);
  remesh_part(patch.draft, target, patch.free, kRounds);
  return find_faults(draft.mesh, put_back(draft, patch));  // the patch holds all that crossed
}

/// Cuts out and closes anew, wider each time, until no fault is left. @return number of places
int cut_and_close(SurfaceDraft& draft, Pairs pairs,
                  Pairs (*find)(const TriangleMesh&, const std::vector<char>&)) {
  constexpr int kAttempts = 8;
  int closed_count = 0;
  for (int attempt = 0; attempt < kAttempts && !pairs.empty(); ++attempt) {
    give_up_rims(draft, pairs);
    std::vector<char> gone = triangles_to_cut(draft, pairs, 1 + attempt);
    keep_largest_pieces(draft.mesh, gone);
    remove_triangles(draft, gone);
    const Closed closed = close_holes(draft);
    closed_count += closed.count;
    pairs = find(draft.mesh, closed.changed);
  }
  return closed_count;
}

}  // namespace

int resolve_crossings(SurfaceDraft& draft, const SurfaceTarget& target,
                      const std::vector<std::array<int, 2>>& others) {
  constexpr int kRemeshings = 2, kAgain = 2;
  Pairs pairs = others;
  if (others.empty()) {
    pairs = find_faults(draft.mesh, std::vector<char>(draft.mesh.triangles.size(), 1));
    for (int attempt = 0; attempt < kRemeshings && !pairs.empty(); ++attempt)
      pairs = remesh_crossings(draft, target, pairs);
  }
  if (pairs.empty()) return 0;
  int closed_count = cut_and_close(draft, pairs, &find_faults);
  Pairs left = air_mesh::self_intersections(draft.mesh);
  for (int again = 0; again < kAgain && !left.empty(); ++again) {
    closed_count += cut_and_close(draft, left, &find_faults);
    left = air_mesh::self_intersections(draft.mesh);
  }
  if (left.empty()) return closed_count;
  const Triangle& first = draft.mesh.triangles[std::size_t(left.front()[0])];
  const Vec3& at = draft.mesh.vertices[std::size_t(first[0])];
  throw InputError(
      "the lumen's surface crosses itself and could not be closed (" + std::to_string(left.size()) +
      " pairs of triangles, the first around (" + std::to_string(std::lround(at.x)) + ", " +
      std::to_string(std::lround(at.y)) + ", " + std::to_string(std::lround(at.z)) +
      ") mm: vessels that touch each other all around, or bone or noise taken for vessels). "
      "Look at the lumen; segmentation.region_lps_mm or seeds_lps_mm take the vessel without it, "
      "meshing.edges_per_circumference shorter edges");
}

int close_openings(SurfaceDraft& draft) { return close_holes(draft).count; }

int close_crossings(TriangleMesh& mesh) {
  SurfaceDraft draft;
  draft.rim.assign(mesh.vertices.size(), -1);
  draft.membrane.assign(mesh.vertices.size(), 0);
  draft.edge_length = mean_edge_lengths(mesh);
  for (const std::vector<int>& loop : boundary_loops(mesh)) {
    for (const int v : loop) draft.rim[std::size_t(v)] = int(draft.rim_planes.size());
    draft.rim_planes.push_back({mesh.vertices[std::size_t(loop[0])], {0.0, 0.0, 1.0}});
  }
  draft.mesh = std::move(mesh);
  const int closed_count = cut_and_close(draft, air_mesh::self_intersections(draft.mesh),
                                         &air_mesh::self_intersections_of);
  mesh = std::move(draft.mesh);
  return closed_count;
}

std::vector<std::array<int, 2>> faults_of_caps(const SurfaceDraft& draft) {
  const CappedMesh capped = cap_rims(draft.mesh, draft.rim);
  const std::size_t wall_count = draft.mesh.triangles.size();
  std::vector<char> is_cap(capped.mesh.triangles.size(), 0);
  std::fill(is_cap.begin() + std::ptrdiff_t(wall_count), is_cap.end(), char(1));
  Pairs pairs = air_mesh::self_intersections_of(capped.mesh, is_cap);
  for (const auto& pair : sharp_folds_of(capped.mesh, is_cap)) pairs.push_back(pair);
  std::set<int> rims;
  for (const auto& pair : pairs)
    for (const int t : pair)
      if (is_cap[std::size_t(t)])
        rims.insert(capped.id[std::size_t(capped.mesh.triangles[std::size_t(t)][0])] - 1);
  Pairs at_rims;
  for (std::size_t t = 0; t < wall_count; ++t)
    for (const int v : draft.mesh.triangles[t])
      if (draft.rim[std::size_t(v)] >= 0 && rims.contains(draft.rim[std::size_t(v)]))
        at_rims.push_back({int(t), int(t)});
  return at_rims;
}

}  // namespace angio::meshing::detail

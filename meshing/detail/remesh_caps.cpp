#include "meshing/detail/remesh_caps.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "air_mesh/build/surface_crossings.hpp"
#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {

TriangleMesh remeshed_cap(const TriangleMesh& cap, const std::vector<char>& on_rim) {
  constexpr int kRounds = 8;
  SurfaceDraft draft;
  draft.mesh = cap;
  draft.rim.assign(cap.vertices.size(), -1);
  std::vector<char> free(cap.vertices.size());
  double rim_length = 0.0;
  int rim_count = 0;
  for (const auto& [a, b] : unique_edges(cap)) {
    if (!on_rim[std::size_t(a)] || !on_rim[std::size_t(b)]) continue;
    rim_length += distance(cap.vertices[std::size_t(a)], cap.vertices[std::size_t(b)]);
    ++rim_count;
  }
  draft.edge_length.assign(cap.vertices.size(), rim_length / std::max(1, rim_count));
  for (std::size_t v = 0; v < free.size(); ++v) {
    free[v] = on_rim[v] ? 0 : 1;
    draft.origin.push_back(int(v));
  }
  remesh_membrane(draft, free, kRounds);
  // The rim's vertices keep their order and come first.
  TriangleMesh result;
  std::vector<int> index(draft.mesh.vertices.size(), -1);
  std::vector<int> of_origin(cap.vertices.size(), -1);
  for (std::size_t v = 0; v < index.size(); ++v)
    if (draft.origin[v] >= 0) of_origin[std::size_t(draft.origin[v])] = int(v);
  for (std::size_t v = 0; v < on_rim.size(); ++v)
    if (on_rim[v] && of_origin[v] < 0) return cap;
  const auto take = [&](int v) {
    if (index[std::size_t(v)] >= 0) return;
    index[std::size_t(v)] = int(result.vertices.size());
    result.vertices.push_back(draft.mesh.vertices[std::size_t(v)]);
  };
  for (std::size_t v = 0; v < on_rim.size(); ++v)
    if (on_rim[v]) take(of_origin[v]);
  for (std::size_t v = 0; v < index.size(); ++v) take(int(v));
  for (const Triangle& t : draft.mesh.triangles)
    result.triangles.push_back(
        {index[std::size_t(t[0])], index[std::size_t(t[1])], index[std::size_t(t[2])]});
  return result;
}

namespace {

/// One cap with vertices of its own.
struct Cap {
  TriangleMesh mesh;
  std::vector<int> whole;  ///< vertex of the capped mesh, of those of the rim
  std::vector<char> on_rim;
};

Cap take_cap(const TriangleMesh& open, const CappedMesh& capped, int id) {
  Cap cap;
  std::vector<int> index(capped.mesh.vertices.size(), -1);
  for (std::size_t v = 0; v < index.size(); ++v) {  // those of the rim come first
    if (capped.id[v] != id) continue;
    index[v] = int(cap.mesh.vertices.size());
    cap.mesh.vertices.push_back(capped.mesh.vertices[v]);
    cap.on_rim.push_back(v < open.vertices.size() ? 1 : 0);
    if (cap.on_rim.back()) cap.whole.push_back(int(v));
  }
  for (std::size_t t = open.triangles.size(); t < capped.mesh.triangles.size(); ++t) {
    const Triangle& c = capped.mesh.triangles[t];
    if (capped.id[std::size_t(c[0])] == id)
      cap.mesh.triangles.push_back(
          {index[std::size_t(c[0])], index[std::size_t(c[1])], index[std::size_t(c[2])]});
  }
  return cap;
}

CappedMesh with_caps(const TriangleMesh& open, const CappedMesh& capped,
                     const std::set<int>& as_they_are) {
  CappedMesh result{open,
                    {capped.id.begin(), capped.id.begin() + std::ptrdiff_t(open.vertices.size())}};
  for (const int id : std::set<int>(capped.id.begin(), capped.id.end())) {
    if (id == 0) continue;
    Cap cap = take_cap(open, capped, id);
    const TriangleMesh mesh =
        as_they_are.contains(id) ? cap.mesh : remeshed_cap(cap.mesh, cap.on_rim);
    for (std::size_t v = cap.whole.size(); v < mesh.vertices.size(); ++v) {
      cap.whole.push_back(int(result.mesh.vertices.size()));
      result.mesh.vertices.push_back(mesh.vertices[v]);
      result.id.push_back(id);
    }
    for (const Triangle& t : mesh.triangles)
      result.mesh.triangles.push_back({cap.whole[std::size_t(t[0])], cap.whole[std::size_t(t[1])],
                                       cap.whole[std::size_t(t[2])]});
  }
  return result;
}

}  // namespace

CappedMesh remesh_caps(const TriangleMesh& open, const CappedMesh& capped) {
  CappedMesh remeshed = with_caps(open, capped, {});
  std::vector<char> is_cap(remeshed.mesh.triangles.size(), 0);
  std::fill(is_cap.begin() + std::ptrdiff_t(open.triangles.size()), is_cap.end(), char(1));
  std::set<int> bad;
  for (const auto& pair : air_mesh::self_intersections_of(remeshed.mesh, is_cap))
    for (const int t : pair)
      if (is_cap[std::size_t(t)])
        bad.insert(remeshed.id[std::size_t(remeshed.mesh.triangles[std::size_t(t)][0])]);
  return bad.empty() ? std::move(remeshed) : with_caps(open, capped, bad);
}

}  // namespace angio::meshing::detail

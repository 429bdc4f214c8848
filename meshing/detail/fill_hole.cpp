#include "meshing/detail/fill_hole.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "air_mesh/build/triangulate_loop.hpp"

namespace angio::meshing::detail {
namespace {

/// Edges of the mesh between vertices of the loop.
std::set<std::array<int, 2>> edges_within(const TriangleMesh& mesh, const std::vector<int>& loop) {
  std::vector<char> in_loop(mesh.vertices.size(), 0);
  for (const int v : loop) in_loop[std::size_t(v)] = 1;
  std::set<std::array<int, 2>> edges;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = t[c];
      const int b = t[(c + 1) % 3];
      if (in_loop[std::size_t(a)] && in_loop[std::size_t(b)])
        edges.insert({std::min(a, b), std::max(a, b)});
    }
  return edges;
}

}  // namespace

void fill_hole(TriangleMesh& mesh, const std::vector<int>& loop) {
  std::vector<Vec3> points;
  Vec3 centre;
  for (const int v : loop) {
    points.push_back(mesh.vertices[std::size_t(v)]);
    centre += points.back() / double(loop.size());
  }
  std::vector<Triangle> patch = air_mesh::triangulate_loop(points);
  const auto edges = edges_within(mesh, loop);
  const int n = int(loop.size());
  bool manifold = !patch.empty();
  for (Triangle& t : patch) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = t[c];
      const int b = t[(c + 1) % 3];
      const bool along_loop = (a + 1) % n == b || (b + 1) % n == a;
      const int va = loop[std::size_t(a)];
      const int vb = loop[std::size_t(b)];
      manifold &= along_loop || !edges.contains({std::min(va, vb), std::max(va, vb)});
    }
  }
  if (manifold) {
    for (const Triangle& t : patch)
      mesh.triangles.push_back(
          {loop[std::size_t(t[0])], loop[std::size_t(t[1])], loop[std::size_t(t[2])]});
    return;
  }
  const int middle = int(mesh.vertices.size());
  mesh.vertices.push_back(centre);
  for (int i = 0; i < n; ++i)
    mesh.triangles.push_back({loop[std::size_t(i)], loop[std::size_t((i + 1) % n)], middle});
}

}  // namespace angio::meshing::detail

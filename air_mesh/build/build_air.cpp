#include "air_mesh/build/build_air.hpp"

#include <utility>

#include "air_mesh/build/gap_mesh.hpp"
#include "air_mesh/build/surface_crossings.hpp"

namespace angio::air_mesh {
namespace {

/// Puts the wall's vertices in place of those of a part of it, between the balloon's and the points
/// in the air.
TetMesh in_numbering_of(const TriangleMesh& wall, const std::vector<int>& wall_vertex,
                        std::size_t balloon_count, TetMesh mesh) {
  if (mesh.tets.empty() || wall_vertex.size() == wall.vertices.size()) return mesh;
  const std::size_t part_end = balloon_count + wall_vertex.size();
  const std::size_t left_out = wall.vertices.size() - wall_vertex.size();
  for (Tet& t : mesh.tets)
    for (int& v : t) {
      const auto u = std::size_t(v);
      if (u >= part_end)
        v += int(left_out);
      else if (u >= balloon_count)
        v = int(balloon_count) + wall_vertex[u - balloon_count];
    }
  std::vector<Vec3> vertices(mesh.vertices.begin(),
                             mesh.vertices.begin() + std::ptrdiff_t(balloon_count));
  vertices.insert(vertices.end(), wall.vertices.begin(), wall.vertices.end());
  vertices.insert(vertices.end(), mesh.vertices.begin() + std::ptrdiff_t(part_end),
                  mesh.vertices.end());
  mesh.vertices = std::move(vertices);
  return mesh;
}

}  // namespace

bool can_build_air() { return true; }

TetMesh build_air(const TriangleMesh& balloon, const TriangleMesh& wall) {
  const auto inside = point_inside(balloon);
  if (!inside || !self_intersections(balloon).empty() || !self_intersections(wall).empty())
    return {};
  const auto closed = close_wall(wall);
  if (!closed || !intersections(balloon, closed->boundary.shell).empty()) return {};
  return in_numbering_of(wall, closed->wall_vertex, balloon.vertices.size(),
                         mesh_gap_with_points(balloon, closed->boundary, *inside));
}

}  // namespace angio::air_mesh

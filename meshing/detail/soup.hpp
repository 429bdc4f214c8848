#pragma once

#include <algorithm>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "meshing/repair_surface.hpp"

/// Steps that make a manifold mesh of triangles from anywhere. Each returns how often it was needed
/// and one of the places.
namespace angio::meshing::detail {

struct Count {
  int count = 0;
  Vec3 where;            ///< the first place, or that of the largest
  double size_mm = 0.0;  ///< of the largest; 0: sizes are not looked at
  void add(const Vec3& place, double size = 0.0) {
    if (count++ == 0 || size > size_mm) where = place;
    size_mm = std::max(size, size_mm);
  }
};

double median_edge_length(const TriangleMesh& mesh);

/// Merges vertices within a distance of each other; drops those that no triangle uses.
Count merge_points(TriangleMesh& mesh, double tolerance);

/// Drops triangles with a repeated corner or without area.
Count drop_degenerate(TriangleMesh& mesh, double tolerance);

/// Drops triangles with the same corners as an earlier one.
Count drop_duplicates(TriangleMesh& mesh);

/// Splits open edges at open vertices that lie on them.
Count join_t_junctions(TriangleMesh& mesh, double tolerance);

/// The connected piece of each vertex, numbered by its first vertex.
std::vector<int> vertex_components(const TriangleMesh& mesh);

/// The triangles of which `keep` is true, and the vertices that they use.
TriangleMesh part_of(const TriangleMesh& mesh, const std::vector<char>& keep);

}  // namespace angio::meshing::detail

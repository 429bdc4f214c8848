#pragma once

#include <array>
#include <vector>

#include "core/vec3.hpp"

namespace angio {

using Triangle = std::array<int, 3>;

/// A surface in LPS [mm]; triangles turn counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;       ///< [mm], shape [vertex_count]
  std::vector<Triangle> triangles;  ///< vertex indices, shape [triangle_count]
};

/// Twice the area times the unit normal of a triangle, [mm^2].
Vec3 area_vector_doubled(const TriangleMesh& mesh, const Triangle& triangle);

/// [mm^2]
double surface_area(const TriangleMesh& mesh);

/// V = 1/6 sum a . (b x c) [mm^3]: the enclosed volume of a closed surface, positive when its
/// normals point outward.
double enclosed_volume(const TriangleMesh& mesh);

/// Area-weighted unit normals, shape [vertex_count]; zero at an isolated vertex.
std::vector<Vec3> vertex_normals(const TriangleMesh& mesh);

/// A third of the area of the triangles around each vertex [mm^2], shape [vertex_count].
std::vector<double> vertex_areas(const TriangleMesh& mesh);

/// Edges (a < b), each once, in ascending order.
std::vector<std::array<int, 2>> unique_edges(const TriangleMesh& mesh);

/// Vertices that share an edge with each vertex, ascending, shape [vertex_count][...].
std::vector<std::vector<int>> vertex_neighbors(const TriangleMesh& mesh);

/// The triangle across each side of each one, shape [triangle_count][3]: side c runs from corner c
/// to the next. -1 at a rim, and where more than two triangles meet in an edge.
std::vector<std::array<int, 3>> triangle_neighbors(const TriangleMesh& mesh);

/// What a mesh checker says of a surface's connectivity.
struct SurfaceTopology {
  int boundary_edge_count = 0;     ///< edges of one triangle
  int nonmanifold_edge_count = 0;  ///< edges of more than two triangles, or of two that disagree
  int component_count = 0;         ///< connected pieces
  int euler_number = 0;            ///< V - E + F over used vertices
  [[nodiscard]] bool is_closed() const {
    return boundary_edge_count == 0 && nonmanifold_edge_count == 0;
  }
};
SurfaceTopology surface_topology(const TriangleMesh& mesh);

/// The rims of an open surface: closed loops of vertices along its boundary edges, ordered so that
/// a cap with the same order has an outward normal; the longest first. No loop visits a vertex
/// twice: rims that meet in one come apart there. Every boundary edge is in exactly one loop if the
/// triangles agree in their orientation.
std::vector<std::vector<int>> boundary_loops(const TriangleMesh& mesh);

}  // namespace angio

#pragma once

#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"

namespace angio::air_mesh {

/// Can this program build air meshes? It takes CGAL and TetGen where the program is compiled.
bool can_build_air();

/// Meshes the air between a balloon and a region of the wall, wherever both have moved. Where the
/// wall has bulged through the cap over a rim the gap ends before it: those triangles have no air.
///
/// @param balloon  closed
/// @return vertices: the balloon's, the wall's, then points in the air, where the gap cannot be
///         filled without; every tet positive or, where surfaces touch, flat. Without tets if the
///         surfaces cross each other or themselves, or TetGen fails
/// @throws Error (69) where can_build_air() is false
TetMesh build_air(const TriangleMesh& balloon, const TriangleMesh& wall);

/// Meshes what some faces enclose, which do not cross.
///
/// @return the given vertices, then points inside, as many as it takes; every tet positive. Without
///         tets if TetGen fails
/// @throws Error (69) where can_build_air() is false
TetMesh mesh_hollow(const std::vector<Vec3>& vertices, const std::vector<Triangle>& faces);

}  // namespace angio::air_mesh

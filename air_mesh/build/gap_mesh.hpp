#pragma once

#include <optional>
#include <string>
#include <vector>

#include "air_mesh/build/gap_boundary.hpp"
#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"

namespace angio::air_mesh {

struct TetrahedralizeResult {
  std::vector<std::array<int, 4>> tets;  ///< over the input's vertices, then added ones
  int added_vertex_count = 0;
};

/// A point inside a closed surface, half way across it: of the ways from its vertices against their
/// normals the longest. Empty if the surface has none.
std::optional<Vec3> point_inside(const TriangleMesh& closed);

/// Runs TetGen with unchanged boundary triangles on a closed shell around a closed inner body,
/// whose inside stays empty. TetGen works in a child process, since it may crash.
///
/// Source: Si, "TetGen, a Delaunay-based quality tetrahedral mesh generator", ACM TOMS 41 (2015)
/// @param vertices      of both bodies [mm]
/// @param triangles     of both bodies
/// @param hole          a point inside the inner body
/// @throws InternalError if TetGen fails, crashes or takes more than `limit_s` seconds of
/// processor time
TetrahedralizeResult tetrahedralize_gap(const std::vector<Vec3>& vertices,
                                        const std::vector<Triangle>& triangles, const Vec3& hole,
                                        double limit_s = 120.0);

struct GapMesh {
  TetMesh tets;
  bool flat_at_inner = false;  ///< is a flat tet at the inner surface left out?
  std::vector<std::string> warnings;
};

/// The air mesh: tetrahedra between an inner closed surface and a region of an outer one, over
/// their vertices only, every one with positive volume.
///
/// Points of a regular balloon lie on common circles and spheres, for which TetGen would add
/// points; if it does, it sees them moved by 1e-5 to 1e-3 mm (the same way on every run).
/// @param inner   closed, inside the shell; must not touch it
/// @param gap     from close_region
/// @param hole    a point inside `inner`
GapMesh mesh_gap(const TriangleMesh& inner, const GapBoundary& gap, const Vec3& hole);

/// A surface whose vertices are moved by up to 1e-4 mm (the same way on every run), so that none
/// lies exactly in a plane of others.
TriangleMesh shaken(TriangleMesh surface);

/// As mesh_gap, with points added in the air where there is no mesh without; no tets if there is
/// none.
TetMesh mesh_gap_with_points(const TriangleMesh& inner, const GapBoundary& gap, const Vec3& hole);

}  // namespace angio::air_mesh

#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::meshing::detail {

/// Fills a hole in a wall as the wall would go on: triangles like those around it, faired.
///
/// Source: Liepa, "Filling holes in meshes", SGP 2003 (CGAL's, with patch_weight.hpp)
/// @param loop  from boundary_loops
void fill_hole_fair(TriangleMesh& mesh, const std::vector<int>& loop);

/// The union of two closed surfaces that cross.
///
/// @return false if it cannot be formed; `a` is then as it was
bool unite_solids(TriangleMesh& a, const TriangleMesh& b);

}  // namespace angio::meshing::detail

#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::meshing::detail {

/// Closes one border loop of a surface: without new vertices if that leaves the surface manifold,
/// else by a fan around one new vertex in the loop's middle, the last of the mesh.
///
/// @param loop  from boundary_loops
void fill_hole(TriangleMesh& mesh, const std::vector<int>& loop);

}  // namespace angio::meshing::detail

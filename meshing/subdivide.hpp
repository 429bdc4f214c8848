#pragma once

#include <array>
#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::meshing {

/// Every triangle in four by the middles of its edges, after the vertices that there are. The
/// surface is the same.
TriangleMesh subdivide(const TriangleMesh& mesh);

/// Sections are measured on a surface's vertices: a coarse mesh, as an experiment's, is subdivided
/// until its edges are as fine as the program's own meshes have them where the lumen is narrowest.
/// @return the edges whose middles become vertices, in their order: later ones may end in earlier
///         middles, which are numbered on from the vertices
std::vector<std::array<int, 2>> edges_to_halve(TriangleMesh lumen, double least_radius_mm);

}  // namespace angio::meshing

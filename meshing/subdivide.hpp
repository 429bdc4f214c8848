#pragma once

#include "core/triangle_mesh.hpp"

namespace angio::meshing {

/// Every triangle in four by the middles of its edges, after the vertices that there are. The
/// surface is the same.
TriangleMesh subdivide(const TriangleMesh& mesh);

/// Sections are measured on a surface's vertices: a coarse mesh, as an experiment's, is subdivided
/// until its edges are as fine as the program's own meshes have them where the lumen is narrowest.
TriangleMesh fine_enough(TriangleMesh lumen, double least_radius_mm);

}  // namespace angio::meshing

#pragma once

#include "core/triangle_mesh.hpp"
#include "datasets/detail/lumen_shape.hpp"

namespace angio::datasets::detail {

/// The closed surface of one straight branch: rings of vertices on the exact wall, in planes across
/// the axis, and flat caps.
///
/// @param vertices_per_ring  >= 8; rings lie as far apart as vertices on a healthy ring
TriangleMesh tube_surface(const LumenShape& shape, int vertices_per_ring);

/// The closed surface of any lumen: marching tetrahedra on Kuhn's subdivision of a grid, which is
/// always a manifold (Doi, Koide, IEICE Trans. E74:214, 1991), over the cells that meet the wall;
/// then vertices are spread evenly and drawn onto the exact wall.
///
/// @param cell_mm  edge of a cell, below the least radius; triangles get about 0.6 of it
TriangleMesh tree_surface(const LumenShape& shape, double cell_mm);

/// The sheet of the seed paper's first experiment: 51 x 51 vertices, 5000 triangles, in the x-y
/// plane around the origin, normals towards +z.
TriangleMesh cloth_surface(double side_mm);

}  // namespace angio::datasets::detail

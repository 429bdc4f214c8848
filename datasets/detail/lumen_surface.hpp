#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"
#include "datasets/detail/lumen_shape.hpp"

namespace angio::datasets::detail {

/// The wall of one straight branch, open at both ends: rings of vertices on the exact wall, in
/// planes across the axis, at equal distances.
///
/// @param ring_count  >= 2
TriangleMesh tube_wall(const LumenShape& shape, int vertices_per_ring, int ring_count);

/// The wall of a trunk and two daughters, open at all three ends: three tubes of equal rings, whose
/// innermost rings are joined half by half in three arcs between two points in front of and behind
/// the plane of the fork. With n vertices a ring and m rows in all it has 2 n m triangles and
/// n m + 3 n / 2 - 1 vertices, on the exact wall; only in the bifurcation rows lean.
///
/// @param vertices_per_ring  even, >= 8
/// @param row_count          of triangles' pairs along the three tubes together, shared out by
///                           their lengths; >= 12
TriangleMesh fork_wall(const LumenShape& shape, int vertices_per_ring, int row_count);

/// Moves vertices towards the middle of their neighbours along the wall, then onto the wall.
///
/// @param held   vertices that stay where they are, shape [vertex_count]; empty: none
/// @param steps  >= 0; with none, vertices are drawn onto the wall only
void spread_on_wall(const LumenShape& shape, TriangleMesh& mesh, const std::vector<char>& held,
                    int steps);

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

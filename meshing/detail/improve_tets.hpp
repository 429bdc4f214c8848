#pragma once

#include <vector>

#include "core/tet_mesh.hpp"

namespace angio::meshing::detail {

/// Raises the least dihedral sines of a tetrahedral mesh around its poor tetrahedra, one step at a
/// time: inner vertices move, edges and faces are swapped, inner edges are contracted and split.
/// A step is taken only if the least sine of the tetrahedra that it touches grows.
///
/// Source: Freitag, Ollivier-Gooch, "Tetrahedral mesh improvement using swapping and smoothing",
///         IJNME 40 (1997); Klingner, Shewchuk, "Aggressive tetrahedral mesh improvement", IMR
///         2007. Departures: vertices are moved by a pattern search; no composed steps.
/// @param fixed_count  the first vertices do not move; the boundary's faces stay
/// @param goal_degrees where a tetrahedron's angles are in [goal, 180 - goal] it is left alone
void improve_tets(TetMesh& mesh, int fixed_count, double goal_degrees);

}  // namespace angio::meshing::detail

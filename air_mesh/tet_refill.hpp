#pragma once

#include <vector>

#include "air_mesh/tet_topology.hpp"

namespace angio::air_mesh {

/// Fills the hollow that a set of tetrahedra leaves with right-handed ones over its own vertices,
/// by a search with back-tracking: the outer face with the fewest possible tets is filled first,
/// with the best of them.
///
/// A closed filling by right-handed tets with the hollow's own outer faces covers it once, so that
/// nothing but the closing has to be checked; crossings with the hollow's outside only prune.
///
/// Source: after Liu, Chen, Sun, "Small polyhedron reconnection", 16th International Meshing
/// Roundtable (2007).
///
/// @param old      tets, each once
/// @param x        [mm], shape [vertex]
/// @param without  a vertex that is to go
/// @return empty if there is none or the search was given up (most_steps tets tried, or too many
///         vertices)
std::vector<Tet> refill(const TetTopology& mesh, const std::vector<Vec3>& x,
                        const std::vector<int>& old, int most_steps, int without = -1);

/// Tets to be replaced by others over the same vertices, with the same outer faces; none: no way.
struct Refilling {
  std::vector<int> old;
  std::vector<Tet> fresh;
};

/// A tet and as few layers of tets around it as can be filled anew.
Refilling refill_around(const TetTopology& mesh, const std::vector<Vec3>& x, int t);

}  // namespace angio::air_mesh

#pragma once

#include <vector>

#include "meshing/detail/cap_rims.hpp"

namespace angio::meshing::detail {

/// A cap with triangles like those at its rim, between the rim's vertices.
///
/// @param cap     its rim's vertices come first
/// @param on_rim  per vertex of the cap
/// @return the rim's vertices first, in their order; the cap as it is if one of them is no corner
///         of a triangle (rims that touch)
TriangleMesh remeshed_cap(const TriangleMesh& cap, const std::vector<char>& on_rim);

/// Every cap remeshed; a cap that would cross the wall by it stays as it is.
///
/// @param open  the lumen without caps, whose vertices and triangles come first in `capped`
CappedMesh remesh_caps(const TriangleMesh& open, const CappedMesh& capped);

}  // namespace angio::meshing::detail

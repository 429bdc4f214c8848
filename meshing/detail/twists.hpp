#pragma once

#include "core/triangle_mesh.hpp"
#include "meshing/detail/soup.hpp"

/// A step that makes a two-sided surface of one with flaws; as soup.hpp.
namespace angio::meshing::detail {

/// Cuts out the triangles at which a ring of neighbours comes back turned inside out, as decimation
/// leaves them at torn edges: of the two triangles at each such edge the smaller one. The sides are
/// told across the flattest edges first (Kruskal's tree), so that the edge is a fold and not the
/// smooth wall beside it.
///
/// A ring longer than a quarter of the surface's extent is no flaw (a Moebius strip's goes all
/// round): that surface is one-sided, and stays as it is for turn_alike to refuse.
Count cut_out_twists(TriangleMesh& mesh);

}  // namespace angio::meshing::detail

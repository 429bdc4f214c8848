#pragma once

#include "meshing/detail/remesh.hpp"
#include "meshing/meshing.hpp"

/// Surfaces of an exact number of triangles.
namespace angio::meshing::detail {

/// Scales the wanted edge lengths so that a remeshing gives about this many triangles.
void aim_at_count(SurfaceDraft& draft, int triangle_count);

/// Splits the longest and collapses the shortest edges off the rims, measured by the wanted
/// lengths, until there are exactly this many triangles, which must be near what there are. Each
/// step changes their number by two.
///
/// @throws InputError if that cannot be reached
void fit_count(SurfaceDraft& draft, const SurfaceTarget& target, int triangle_count);

/// Sides of the opening that `close_but_inlet` leaves.
inline constexpr int kInletSides = 8;

/// Triangles that `close_but_inlet` adds to a surface with these rims.
int closing_triangle_count(const TriangleMesh& open);

/// Closes the outlets by caps, and the inlet by a cap with an octagonal opening for the catheter: V
/// - F/2 = 5, as in the seed paper's Table 2 for its coronary (15215 - 15210). (A surface with h
/// openings and b border edges has V - F/2 = 2 - h + b/2; with b = 3 h at least, no surface with
/// more than six openings has those counts.)
void close_but_inlet(LumenMesh& lumen);

}  // namespace angio::meshing::detail

#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"
#include "meshing/detail/soup.hpp"
#include "meshing/repair_surface.hpp"

/// The pieces of a surface: apart, nested, overlapping.
namespace angio::meshing::detail {

/// The connected pieces.
std::vector<TriangleMesh> connected_pieces(const TriangleMesh& mesh);

/// All in one mesh, side by side.
TriangleMesh joined(const std::vector<TriangleMesh>& parts);

/// A copy whose openings are closed by the shortest way.
TriangleMesh closed_copy(const TriangleMesh& mesh);

/// Of several manifold pieces, what is the lumen.
///
/// Each piece is turned outward. Of pieces inside others the inner one is the lumen and the other
/// its wall, where it fills a fifth of it and runs along most of it; otherwise what is inside is no
/// wall of the lumen. Pieces that cross are united, openings that are not inside another stay open.
/// Of what is then apart the largest is kept, or all.
///
/// @throws InputError if pieces overlap and cannot be united
TriangleMesh settle_pieces(const TriangleMesh& mesh, const SurfaceRepairOptions& options,
                           std::vector<SurfaceRepair>& repairs);

/// A surface whose triangles cross each other made free of crossings: cut out and closed anew where
/// they are few, otherwise as the union of what overlaps.
///
/// @throws InputError if neither encloses what the surface did
TriangleMesh without_crossings(const TriangleMesh& mesh, std::vector<SurfaceRepair>& repairs);

/// Appends what was done, unless it was nothing.
void note(std::vector<SurfaceRepair>& repairs, const char* one, const char* many,
          const Count& count);

}  // namespace angio::meshing::detail

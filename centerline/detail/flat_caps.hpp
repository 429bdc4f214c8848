#pragma once

#include <vector>

#include "centerline/detail/openings.hpp"
#include "core/triangle_mesh.hpp"

namespace angio::centerline {

/// Opens a closed surface where vessels were cut off: removes its flat caps.
///
/// A cap is a flat piece (triangles within 3 degrees of one plane) that the wall leaves by a sharp
/// edge (over 30 degrees, on nine tenths of its rim) towards the inside all round, that is round
/// (4 pi area / perimeter^2 over 0.4) and wider than four triangles' edges, or a polygon of six
/// edges or more (over 0.85, which no rectangle has). A wall has no such piece: where it is flat it
/// goes on without an edge. The stairs of a voxel mask have; they are rough, and not to be asked
/// for.
///
/// @param closed  outward normals
/// @return the surface without its caps; the same surface where it has none
TriangleMesh remove_flat_caps(const TriangleMesh& closed);

/// The flat ends of a closed surface whose edges are rounded, as smoothing leaves them.
///
/// One is a flat piece (within 10 degrees of its mean normal), as wide as six triangles' edges,
/// that is with its edge, as far as that turns by no more than 60 degrees, at most three times as
/// large, and round (three quarters within the disc of its area). Of a round tip the flat piece is
/// a thirtieth, of a tube's side a sixth. A sac has none.
///
/// @param closed  outward normals, without sharp caps
std::vector<OpenRim> find_flat_ends(const TriangleMesh& closed);

}  // namespace angio::centerline

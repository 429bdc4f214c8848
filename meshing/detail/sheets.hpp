#pragma once

#include "core/triangle_mesh.hpp"
#include "meshing/detail/soup.hpp"

/// Steps that make a manifold of sheets that cross, meet, or are turned inside out; as soup.hpp.
namespace angio::meshing::detail {

/// Cuts off the smaller sheets with a free border that meet others in edges of three and more
/// triangles.
Count cut_off_fins(TriangleMesh& mesh);

/// Turns triangles like most of their neighbours.
///
/// @throws InputError if the surface is one-sided
Count turn_alike(TriangleMesh& mesh);

/// Gives every sheet its own vertices where several meet in an edge or in a corner. In an edge,
/// those two triangles stay together between which the inside lies; where sheets that meet in an
/// edge hang together at both its ends, the edge of one is halved. A side that goes with no other
/// (an odd number meets, or two are turned alike) is set free, and leaves a border.
Count take_sheets_apart(TriangleMesh& mesh);

}  // namespace angio::meshing::detail

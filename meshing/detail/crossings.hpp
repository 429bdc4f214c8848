#pragma once

#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {

/// Rids a surface of crossing triangles: cuts out the triangles that cross with those around them,
/// keeps the largest piece, closes the holes by membranes, and looks again, cutting wider each
/// time. Necks and pockets that the data cannot resolve vanish in this way.
///
/// @return number of places that were closed anew
/// @throws InternalError if crossings remain
int resolve_crossings(SurfaceDraft& draft);

}  // namespace angio::meshing::detail

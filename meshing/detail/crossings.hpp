#pragma once

#include <string>
#include <vector>

#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {

/// Rids a surface of crossing triangles. First it is remeshed around them. What still crosses,
/// necks and pockets that the data cannot resolve, is cut out with the triangles around it, the
/// largest piece is kept, and the holes are closed by membranes; then again, wider. A rim that is
/// hit, or lost with a piece, is no rim any more, and named in a warning.
///
/// @return number of places that were closed anew
/// @throws InternalError if crossings remain
int resolve_crossings(SurfaceDraft& draft, const SurfaceTarget& target,
                      std::vector<std::string>& warnings);

}  // namespace angio::meshing::detail

#pragma once

#include <array>
#include <string>
#include <vector>

#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {

/// Rids a surface of crossing triangles and sharp folds. First it is remeshed around them. What is
/// left, necks and pockets that the data cannot resolve, is cut out with the triangles around it,
/// the largest piece is kept, and the holes are closed by membranes; then again, wider. A rim that
/// is hit, or lost with a piece, is no rim any more.
///
/// @param others  pairs of triangles (or of a triangle and itself) to cut out of a surface that has
///                no faults besides; none: faults are searched
/// @return number of places that were closed anew
/// @throws InputError if crossings remain
int resolve_crossings(SurfaceDraft& draft, const SurfaceTarget& target,
                      const std::vector<std::array<int, 2>>& others);

/// Closes every opening that is no rim by a membrane: where an end was too fine to stay one.
/// @return how many
int close_openings(SurfaceDraft& draft);

/// As resolve_crossings, for a surface without a target, by cutting and closing alone; its openings
/// stay.
///
/// @return number of places that were closed anew; crossings may remain
int close_crossings(TriangleMesh& mesh);

/// Triangles of the wall at rims whose caps would cross the wall or fold onto it, each as a pair
/// with itself.
std::vector<std::array<int, 2>> faults_of_caps(const SurfaceDraft& draft);

}  // namespace angio::meshing::detail

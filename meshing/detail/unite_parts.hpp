#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::meshing::detail {

/// The surface of the union of closed parts, or of one that crosses itself.
struct Union {
  TriangleMesh mesh;        ///< empty: the parts cannot be united
  bool only_touch = false;  ///< no part overlaps another; nothing was done
  double too_many = 0.0;    ///< triangles of a contour fine enough for the thinnest part, if they
                            ///< are too many to be made
};

/// Unites closed surfaces that are turned outward and hang together by crossing each other; each
/// may cross itself.
///
/// First exactly, on the triangles themselves (CGAL's corefinement). Where that fails, or where the
/// result is not the union, the places where the winding number is above 0 are contoured on a grid
/// of an eighth of the thinnest part's diameter (Jacobson, Kavan, Sorkine-Hornung, "Robust inside-
/// outside segmentation using generalized winding numbers", ACM TOG 32, 2013; here it is an
/// integer, as the parts are closed); of a large one up to a quarter. Memory and
/// time grow with the wall's area: nodes are kept beside it only. A wall of over 1.2 million of the
/// grid's squares is not contoured. A result counts only if it is manifold, free of crossings and
/// encloses the volume where the winding number is above 0, to 2 %.
Union unite_parts(const std::vector<TriangleMesh>& parts);

/// The volume inside a closed surface, each place counted once however parts of it overlap.
double volume_of_union(const TriangleMesh& closed);

}  // namespace angio::meshing::detail

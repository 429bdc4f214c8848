#pragma once

#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "meshing/detail/open_ends.hpp"
#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {

/// The connected pieces that the lines run through: for each tree the one nearest to most of its
/// points.
TriangleMesh components_of_lines(const TriangleMesh& mesh, const CenterlineTree& lines);

/// A given surface, and the same opened.
struct OpenedSurface {
  TriangleMesh repaired;  ///< manifold and outward; openings but flat ones at line ends are filled
  SurfaceDraft draft;     ///< open at its lines' ends
};

/// Opens a given surface at every line end. Flat openings at line ends stay as they are; elsewhere
/// a plane across the line cuts the end off. Where none does, as in a mouth out of which a branch
/// comes, an opening that is not flat stays, straightened. What was repaired, and what cannot be
/// opened, is a warning.
///
/// @throws InputError if nothing is left of it
OpenedSurface open_surface(const TriangleMesh& surface, const CenterlineTree& tree,
                           const std::vector<LineEnd>& ends, std::vector<std::string>& warnings);

/// Opens the lumen at every line end that is not open yet; what cannot be opened is a warning.
/// @return indices of ends that stay closed
std::vector<int> open_ends(SurfaceDraft& draft, const CenterlineTree& tree,
                           const std::vector<LineEnd>& ends, std::vector<std::string>& warnings);

}  // namespace angio::meshing::detail

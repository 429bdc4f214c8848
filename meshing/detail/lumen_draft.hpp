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

/// A given surface made manifold and outward; flat openings at line ends stay open as rims, other
/// openings are filled. What was repaired is a warning.
///
/// @throws InputError if nothing is left of it
SurfaceDraft repaired_draft(const TriangleMesh& surface, const CenterlineTree& tree,
                            const std::vector<LineEnd>& ends, std::vector<std::string>& warnings);

/// Opens the lumen at every line end that is not open yet; what cannot be opened is a warning.
void open_ends(SurfaceDraft& draft, const CenterlineTree& tree, const std::vector<LineEnd>& ends,
               std::vector<std::string>& warnings);

}  // namespace angio::meshing::detail

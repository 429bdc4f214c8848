#pragma once

#include <vector>

#include "meshing/wall_layers.hpp"

namespace angio::meshing::detail {

/// What untangling did.
struct Untangled {
  std::vector<char> moved;  ///< shape [lumen_vertex_count]
  int left_count = 0;  ///< wedges that are still wrong, and pairs of crossing triangles outside
};

/// Makes every wedge of a wall right-handed and its outside free of crossings. Around wrong ones
/// the ways from the lumen outward are made more alike and a little shorter until that is so; the
/// lumen's vertices stay.
///
/// @param least_share  of the determinant that a straight wedge on the same triangle has
Untangled untangle(WallLayers& wall, const TriangleMesh& lumen, double least_share);

}  // namespace angio::meshing::detail

#pragma once

#include "meshing/wall_layers.hpp"

namespace angio::meshing::detail {

/// Makes every wedge of a wall right-handed and its outside free of crossings. Around wrong ones
/// the ways from the lumen outward are made more alike and a little shorter until that is so; the
/// lumen's vertices stay.
///
/// @param least_shape  of a wedge: at each corner, the determinant of the three edges over the
///                     product of their lengths
/// @return how many of the lumen's vertices are still at a wrong wedge, or at a crossing outside
int untangle(WallLayers& wall, const TriangleMesh& lumen, double least_shape);

}  // namespace angio::meshing::detail

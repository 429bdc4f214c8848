#pragma once

#include "meshing/wall_layers.hpp"

namespace angio::meshing::detail {

/// Makes every wedge of a wall right-handed and its outside free of crossings, as far as that can
/// be. Around wrong ones the ways from the lumen outward are made more alike, rising from the
/// triangles around, and a little shorter; the lumen's vertices stay.
///
/// @param good_shape    of a wedge, sought: at each corner, the determinant of the three edges over
///                      the product of their lengths
/// @param least_shape   accepted
/// @param least_length  to the outside [mm], below which no way is shortened, shape [lumen vertex]
/// @return for each triangle of the lumen, whether a wedge over it is still wrong, or the outside
///         crosses itself there
std::vector<char> untangle(WallLayers& wall, const TriangleMesh& lumen, double good_shape,
                           double least_shape, const std::vector<double>& least_length);

}  // namespace angio::meshing::detail

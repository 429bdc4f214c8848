#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::air_mesh {

/// Triangles that close a loop of points without new points: as few sharp folds and as small an
/// area as possible. Empty if there is none.
///
/// @param loop  at least three points [mm]
/// @return indices into `loop`, turning as the loop does
std::vector<Triangle> triangulate_loop(const std::vector<Vec3>& loop);

}  // namespace angio::air_mesh

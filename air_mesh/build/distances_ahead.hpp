#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::air_mesh {

/// From which side a ray meets a surface.
enum class Side { outside, inside };

/// The distance [mm] from each vertex along its unit direction to the next triangle that is met
/// from a side, infinity if none is within reach. Triangles around the vertex do not count.
///
/// @param reach  of each vertex [mm]
std::vector<double> distances_ahead(const TriangleMesh& surface,
                                    const std::vector<Vec3>& directions,
                                    const std::vector<double>& reach, Side side);

}  // namespace angio::air_mesh

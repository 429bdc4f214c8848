#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::simulation::detail {

/// 2 sqrt(area / pi) of a closed tube's section through a point across the tube's own axis there
/// [mm]: the direction in which the middles of its sections follow each other, found from a guess.
/// Of the curves that a plane cuts out the one whose middle is nearest to the point counts.
///
/// @param triangles  of the tube, into x
/// @param guess      of the axis, unit
/// @return 0 where no plane meets the tube
double diameter_across(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x,
                       const Vec3& point, const Vec3& guess);

}  // namespace angio::simulation::detail

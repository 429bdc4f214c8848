#pragma once

#include "datasets/detail/lumen_shape.hpp"

namespace angio::datasets::detail {

/// The distance from a point inside along a unit direction to the wall of the lumen [mm], which
/// goes on past its ends.
double distance_to_wall(const LumenShape& shape, const Vec3& from, const Vec3& direction);

/// Area [mm^2] of the section through a point inside, at right angles to a unit direction: of its
/// part seen from that point,
///
///     A = 1/2 int_0^2pi rho(theta)^2 d theta
///
/// by the trapezoidal rule, which for a smooth outline is exact to rounding.
double section_area(const LumenShape& shape, const Vec3& center, const Vec3& normal);

}  // namespace angio::datasets::detail

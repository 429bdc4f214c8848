#pragma once

#include "core/triangle_mesh.hpp"
#include "datasets/detail/lumen_shape.hpp"

namespace angio::datasets::detail {

/// The closed surface of a lumen as users get it, with edges of a seventh of the radius or less.
TriangleMesh usual_surface(const LumenShape& shape, double radius_mm);

/// The same for projections: its facets leave the wall by less than 0.001 of its radius.
TriangleMesh fine_surface(const LumenShape& shape, double radius_mm);

}  // namespace angio::datasets::detail

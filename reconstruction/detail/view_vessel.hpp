#pragma once

#include "reconstruction/detail/view_picture.hpp"
#include "reconstruction/views.hpp"

namespace angio::reconstruction::detail {

/// Leaves of a view's lines the one vessel between two places: the path of least cost
///
///     sum over pixels of 1 + (d / 1 pixel)^2,   d: from the nearest line, up to 8 pixels
///
/// It bridges gaps; its pixels carry the radius of the nearest line.
void keep_vessel(ViewPicture& view, const VesselEnds& ends);

}  // namespace angio::reconstruction::detail

#pragma once

#include <array>

namespace angio::viewer::detail {

/// A place in a picture of three axes of length 1, its middle their origin; x to the right, y up.
using AxisSpot = std::array<double, 2>;

/// Where the axes' letters stand: beyond their tips, but off each other and off the other axes,
/// however the axes are turned; an axis that points at the eye has its letter beside the origin.
///
/// @param tips  seen from the eye, shape [axis]
/// @return the letters' middles, 0.36 or more apart, within 1.4 of the origin along x and y
std::array<AxisSpot, 3> place_axis_letters(const std::array<AxisSpot, 3>& tips);

}  // namespace angio::viewer::detail

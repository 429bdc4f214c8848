#pragma once

#include <vector>

#include "reconstruction/detail/view_picture.hpp"
#include "reconstruction/views.hpp"

namespace angio::reconstruction::detail {

/// The part of a picture that no collimator covers, less its blurred edge: a leaf lies along a side
/// of the picture, lets less than half of the beam through (or is painted over with more than
/// twice of it), and ends in a straight line.
/// @param picture  line integrals, shape [rows, columns]
OpenField open_field(const std::vector<float>& picture, int columns, int rows);

/// A view's picture of its vessels, and their lines.
/// @param air      as RunQuality::unattenuated
/// @param covered  pixels that are no picture, 1; empty: none
/// @throws InputError  its shutter covers all of it
ViewPicture read_view(const RotationalRun& run, int index, double air, double widest_mm,
                      std::vector<char> covered);

}  // namespace angio::reconstruction::detail

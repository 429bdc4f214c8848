#pragma once

#include <vector>

#include "reconstruction/detail/view_picture.hpp"
#include "reconstruction/views.hpp"

namespace angio::reconstruction::detail {

/// A view's picture of its vessels, and their lines.
/// @param air      as RunQuality::unattenuated
/// @param covered  pixels that are no picture, 1; empty: none
/// @throws InputError  its shutter covers all of it
ViewPicture read_view(const RotationalRun& run, int index, double air, double widest_mm,
                      std::vector<char> covered);

}  // namespace angio::reconstruction::detail

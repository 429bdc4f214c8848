#pragma once

#include "centerline/detail/line_shape.hpp"
#include "centerline/detail/wall.hpp"

/// The free ends of a line.
namespace angio::centerline {

/// Draws the free ends straight on to the wall, or to the border of the data.
void redo_ends(Line& work, const Surroundings& around);

/// A tip that was centred after it had been drawn to the wall, or to the border of the data, may
/// lie beyond it: cuts it off.
void stay_in_lumen(Line& work, const Wall& wall);

}  // namespace angio::centerline

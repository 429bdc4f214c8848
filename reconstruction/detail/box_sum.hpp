#pragma once

#include <vector>

namespace angio::reconstruction::detail {

/// Sums over the squares of 2 half + 1 pixels in both directions around each, cut at the border, in
/// place.
/// @param values  shape [rows, columns]
/// @param above   room for sums, kept from one call to the next: memory that is new to the program
///                would take longer than the sums
void box_sum(std::vector<double>& values, int columns, int rows, int half,
             std::vector<double>& above);

}  // namespace angio::reconstruction::detail

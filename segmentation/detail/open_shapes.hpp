#pragma once

#include <vector>

namespace angio::segmentation::detail {

/// A round shutter's border: the corners of a polygon about the circle that leaves no pixel out,
/// column and row in turn.
std::vector<double> circle_corners(double column, double row, double radius);

/// Which pixel's value each pixel takes where a shutter covers some: its own if it is open, else
/// that of an open one as near as any (to a pixel).
/// @param shapes  as ProjectionRun::open_shapes
/// @return shape [rows, columns]; empty: all are open, or none is (the shutter is not stated right)
std::vector<int> open_pixels(const std::vector<std::vector<double>>& shapes, int columns, int rows);

}  // namespace angio::segmentation::detail

#pragma once

#include "viewer/detail/chart.hpp"
#include "viewer/detail/picture.hpp"

namespace angio::viewer::detail {

/// A chart as a picture, for programs that read no SVG: the same lines, levels, marks and axes,
/// with a legend; bands are the thin upright lines between them. An OffscreenDisplay must live.
/// @param scale  pixels per pixel of the chart's size, >= 1
Picture chart_picture(const Chart& chart, int scale);

}  // namespace angio::viewer::detail

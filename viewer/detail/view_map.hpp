#pragma once

#include <string>

#include "angiogram/working_view.hpp"

namespace angio::viewer::detail {

/// The C-arm's views by their angles as an inline SVG element: foreshortening as bands of colour,
/// hatched where other vessels overlap, best and second view marked. Empty for an empty map.
std::string view_map_svg(const angiogram::WorkingView& view);

/// What the colours and the hatching mean, as HTML.
std::string view_map_key();

}  // namespace angio::viewer::detail

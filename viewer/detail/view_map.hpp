#pragma once

#include <string>

#include "angiogram/working_view.hpp"

namespace angio::viewer::detail {

/// The C-arm's views by their angles as an inline SVG element: foreshortening as bands of colour,
/// hatched where other vessels overlap, best and second view marked. Empty for an empty map.
enum class MapWidth { wide, narrow };
std::string view_map_svg(const angiogram::WorkingView& view, MapWidth width = MapWidth::wide);

/// Both, of which the page's style shows one.
std::string view_map_for_page(const angiogram::WorkingView& view);

/// What the colours and the hatching mean, as HTML.
/// @param seen    what is looked at: "the lesion"
/// @param others  what may hide it: "other vessels"
std::string view_map_key(const std::string& seen, const std::string& others);

}  // namespace angio::viewer::detail

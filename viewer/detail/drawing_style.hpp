#pragma once

#include <string>

namespace angio::viewer::detail {

/// An inline SVG element of the page as a file of its own: with its name space, and the page's
/// rules for drawings in its light colours.
std::string styled_drawing(const std::string& element);

}  // namespace angio::viewer::detail

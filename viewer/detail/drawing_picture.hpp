#pragma once

#include <string>

#include "viewer/detail/picture.hpp"

namespace angio::viewer::detail {

/// A drawing of ours as a picture on white paper.
///
/// @param svg    a whole SVG file, with its size [px]
/// @param scale  pixels of the picture for each of the drawing, >= 1
Picture drawing_picture(const std::string& svg, int scale);

}  // namespace angio::viewer::detail

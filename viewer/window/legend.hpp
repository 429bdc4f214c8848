#pragma once

#include <vtkRenderer.h>

#include <string>
#include <utility>
#include <vector>

#include "viewer/detail/picture.hpp"

namespace angio::viewer::window {

/// Writes words in their colours, one after another in a line.
/// @param left, top  of the first, as fractions of the view
void add_legend(vtkRenderer* renderer, double left, double top,
                const std::vector<std::pair<std::string, detail::Rgb>>& words);

}  // namespace angio::viewer::window

#pragma once

#include "viewer/detail/picture.hpp"

/// The colours of contours before and after the dilation, in sections and windows alike.
namespace angio::viewer::detail::moment_colors {

inline constexpr Rgb kBefore{70, 200, 255};
inline constexpr Rgb kAfter{255, 160, 40};

}  // namespace angio::viewer::detail::moment_colors

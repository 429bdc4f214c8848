#pragma once

#include "viewer/detail/moment_colors.hpp"
#include "viewer/detail/picture.hpp"

/// What a colour means in the section, in the curve and on the buttons; the moments have the
/// report's colours.
namespace angio::viewer::window::colors {

using detail::moment_colors::kAfter;
using detail::moment_colors::kBefore;
inline constexpr detail::Rgb kNow{126, 224, 129};  ///< the frame shown; in the curve the peak
inline constexpr detail::Rgb kBalloon{70, 140, 255};
inline constexpr detail::Rgb kCursor{255, 220, 50};
inline constexpr detail::Rgb kInk{222, 226, 232};
inline constexpr detail::Rgb kFaintInk{150, 156, 168};
inline constexpr detail::Rgb kPanel{28, 32, 40};
inline constexpr detail::Rgb kButton{52, 58, 70};
inline constexpr detail::Rgb kButtonOn{38, 98, 176};
inline constexpr detail::Rgb kButtonTouched{78, 88, 106};

}  // namespace angio::viewer::window::colors

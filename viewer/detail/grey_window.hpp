#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "viewer/detail/plane.hpp"

namespace angio::viewer::detail {

/// What is shown as black and as white.
struct GreyWindow {
  float black = 0.0f;
  float white = 1.0f;

  /// What is no number is black.
  [[nodiscard]] std::uint8_t shade(float value) const {
    const float share = (value - black) / (white - black);
    return std::uint8_t(255.0f * std::clamp(std::isfinite(share) ? share : 0.0f, 0.0f, 1.0f));
  }
};

/// Clips the darkest 1 % and the brightest 0.3 %, whatever the modality's units.
inline GreyWindow window_of(const std::vector<float>& values) {
  GreyWindow window{percentile(values, 0.01), percentile(values, 0.997)};
  if (window.white <= window.black) window.white = window.black + 1.0f;
  return window;
}

}  // namespace angio::viewer::detail

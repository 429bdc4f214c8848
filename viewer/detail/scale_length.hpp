#pragma once

#include <cmath>

namespace angio::viewer::detail {

/// The length of a scale bar: the longest of 1, 2, 5, 10, ... (and 0.5, 0.2, ...) that fits.
/// @param room_mm  > 0
inline double scale_length(double room_mm) {
  const double power = std::pow(10.0, std::floor(std::log10(room_mm)));
  return (room_mm >= 5.0 * power ? 5.0 : room_mm >= 2.0 * power ? 2.0 : 1.0) * power;
}

}  // namespace angio::viewer::detail

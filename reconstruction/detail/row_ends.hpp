#pragma once

#include <cmath>

#include "core/host_device.hpp"

/// What lies beyond the ends of a detector's row. The same code runs on CPU and GPU.
namespace angio::reconstruction::detail {

inline constexpr double kWater =
    0.0206;                      ///< [1/mm] at 60 keV (NIST, Hubbell, Seltzer, NISTIR 5632)
inline constexpr int kEdge = 8;  ///< pixels that tell a row's value and slope at its end
inline constexpr double kWithinBody = 0.15;  ///< a line integral of 7 mm of water

/// A row's value and its slope outward at an end, by a line through the last pixels.
struct RowEnd {
  double value = 0.0, slope = 0.0;
};

/// @param row  the value of pixel i of `columns`: row(i)
template <class Row>
ANGIO_HOST_DEVICE inline RowEnd row_end(const Row& row, int columns, bool is_last) {
  const int count = kEdge < columns ? kEdge : columns;
  const double middle = 0.5 * (count - 1);
  double mean = 0.0, rise = 0.0, spread = 0.0;
  for (int i = 0; i < count; ++i) {
    const double value = double(row(is_last ? columns - 1 - i : i));
    mean += value / count;
    rise += (middle - i) * value;  // i grows inward
    spread += (i - middle) * (i - middle);
  }
  const double slope = spread > 0.0 ? rise / spread : 0.0;
  return {mean + slope * middle, slope};
}

/// Does a row end within the body there?
ANGIO_HOST_DEVICE inline bool is_within_body(const RowEnd& end) { return end.value > kWithinBody; }

/// The cylinder of water that a row goes on as (Hsieh et al., Med. Phys. 31:2385, 2004, eq. 5-7):
/// the chord p = 2 mu sqrt(r^2 - x^2) has the row's value and slope at its end.
struct WaterEdge {
  double x;               ///< of the end, from the cylinder's axis [mm]
  double radius_squared;  ///< [mm^2]

  /// Pixel i, counted outward from the end.
  [[nodiscard]] ANGIO_HOST_DEVICE float beyond(int i, double spacing_mm) const {
    const double at = x + (i + 1) * spacing_mm, left = radius_squared - at * at;
    return left > 0.0 ? float(2.0 * kWater * std::sqrt(left)) : 0.0F;
  }
};

ANGIO_HOST_DEVICE inline WaterEdge water_edge(const RowEnd& end, double spacing_mm) {
  const double value = end.value > 0.0 ? end.value : 0.0;
  const double slope = end.slope < 0.0 ? end.slope / spacing_mm : 0.0;
  const double scale = 1.0 / (4.0 * kWater * kWater);
  const double x = -value * slope * scale;
  return {x, value * value * scale + x * x};
}

}  // namespace angio::reconstruction::detail

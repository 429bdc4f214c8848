#pragma once

#include <algorithm>
#include <cmath>

namespace angio::reconstruction::detail {

/// How far rays go through a round tube that they meet at right angles, and its derivatives.
struct TubeChord {
  double value = 0.0;        ///< [mm]
  double by_distance = 0.0;  ///< of the ray from the axis
  double by_radius = 0.0;
  double by_width = 0.0;
};

/// The mean over a box of rays across the tube,
///
///     K(d, r, w) = (A(d + w/2) - A(d - w/2)) / w,   A(x) = x sqrt(r^2 - x^2) + r^2 asin(x / r),
///
/// with x held in [-r, r]: the integral of the chord 2 sqrt(r^2 - x^2). A pixel's aperture is a box
/// of its own width to second order in any direction (the variance of a square is the same along
/// all), and a detector's blur of sd b widens it to sqrt(pixel^2 + 12 b^2).
///
/// @param distance  d [mm]
/// @param radius    r, > 0
/// @param width     w, > 0
inline TubeChord blurred_chord(double distance, double radius, double width) {
  const double upper = std::clamp(distance + 0.5 * width, -radius, radius);
  const double lower = std::clamp(distance - 0.5 * width, -radius, radius);
  const double upper_half = std::sqrt(std::max(0.0, radius * radius - upper * upper));
  const double lower_half = std::sqrt(std::max(0.0, radius * radius - lower * lower));
  const double angle = std::asin(upper / radius) - std::asin(lower / radius);
  TubeChord chord;
  chord.value = (upper * upper_half - lower * lower_half + radius * radius * angle) / width;
  chord.by_distance = 2.0 * (upper_half - lower_half) / width;
  chord.by_radius = 2.0 * radius * angle / width;
  chord.by_width = (upper_half + lower_half - chord.value) / width;
  return chord;
}

}  // namespace angio::reconstruction::detail

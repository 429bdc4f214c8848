#pragma once

#include <algorithm>
#include <cmath>

namespace angio::reconstruction::detail {

/// How far rays go through a round, even tube that they meet at right angles, and its derivatives.
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

/// What tells the way of a ray through a tube that it meets at any angle.
struct ObliqueTube {
  double distance = 0.0;    ///< of the ray from the axis [mm]
  double log_radius = 0.0;  ///< L, ln [mm], where the ray is nearest to the axis: at the foot
  double slope = 0.0;       ///< L', along the axis [1/mm]
  double bend = 0.0;        ///< L'' [1/mm^2]
  double cosine = 0.0;      ///< c, of the angle between ray and axis
  double width = 0.0;       ///< of the box of rays [mm]
};

/// A length [mm] and its derivatives.
struct ObliqueLength {
  double value = 0.0;
  double by_distance = 0.0, by_log_radius = 0.0, by_slope = 0.0, by_bend = 0.0, by_cosine = 0.0,
         by_width = 0.0;
};

struct ObliqueChord {
  ObliqueLength way;     ///< through the tube
  ObliqueLength middle;  ///< of that way, from the foot along the ray
};

/// The way of a ray through a tube whose radius changes along its axis. At t from the foot the ray
/// is at s = c t along the axis and inside of the tube where
///
///     d^2 + t^2 (1 - c^2) < r(c t)^2 = r^2 + 2 r r' c t + q c^2 t^2,   q = r^2 (2 L'^2 + L''),
///
/// to second order in s: an oblique ray through a throat meets the wider lumen beside it. So it is
/// the chord of a round tube (blurred_chord()) with r^2 + (r r' c / S)^2 for r^2, over S, where
///
///     S^2 = (1 - c^2) f(x),   x = q c^2 / (1 - c^2),   f = 1 - x for x < 0, else 1 / (1 + x),
///
/// the same to first order, and never zero; its middle is r r' c / S^2 from the foot.
inline ObliqueChord oblique_chord(const ObliqueTube& tube) {
  const double c = tube.cosine, n = 1.0 - c * c;
  const double square = std::exp(2.0 * tube.log_radius);  // of the radius
  const double q = square * (2.0 * tube.slope * tube.slope + tube.bend);
  const double x = q * c * c / n;
  const double f = x < 0.0 ? 1.0 - x : 1.0 / (1.0 + x);
  const double by_x = n * (x < 0.0 ? -1.0 : -f * f);  // of S^2
  const double sine_square = n * f, sine = std::sqrt(sine_square);
  // Of S^2 by what it depends on.
  const double by_q = by_x * c * c / n;
  const double s_by_log = by_q * 2.0 * q, s_by_slope = by_q * 4.0 * square * tube.slope,
               s_by_bend = by_q * square, s_by_cosine = -2.0 * c * f + by_x * 2.0 * q * c / (n * n);
  const double lean = square * tube.slope * c;  // r r' c
  const double radius = std::sqrt(square + lean * lean / sine_square);
  const TubeChord chord = blurred_chord(tube.distance, radius, tube.width);
  // way = K(d, R, w) / S,  R^2 = r^2 + lean^2 / S^2.
  const double by_square = 0.5 * chord.by_radius / (radius * sine);  // by R^2
  const double by_lean = by_square * 2.0 * lean / sine_square;
  const double by_sine_square = -by_square * lean * lean / (sine_square * sine_square) -
                                0.5 * chord.value / (sine_square * sine);
  ObliqueChord result;
  result.way.value = chord.value / sine;
  result.way.by_distance = chord.by_distance / sine;
  result.way.by_width = chord.by_width / sine;
  result.way.by_log_radius =
      2.0 * square * by_square + 2.0 * lean * by_lean + s_by_log * by_sine_square;
  result.way.by_slope = square * c * by_lean + s_by_slope * by_sine_square;
  result.way.by_bend = s_by_bend * by_sine_square;
  result.way.by_cosine = square * tube.slope * by_lean + s_by_cosine * by_sine_square;
  ObliqueLength& middle = result.middle;
  middle.value = lean / sine_square;
  const double middle_by_s = -middle.value / sine_square;
  middle.by_log_radius = 2.0 * middle.value + s_by_log * middle_by_s;
  middle.by_slope = square * c / sine_square + s_by_slope * middle_by_s;
  middle.by_bend = s_by_bend * middle_by_s;
  middle.by_cosine = square * tube.slope / sine_square + s_by_cosine * middle_by_s;
  return result;
}

}  // namespace angio::reconstruction::detail

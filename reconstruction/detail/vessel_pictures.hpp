#pragma once

#include <cstdint>
#include <vector>

/// The vessels of a frame alone: a mask run that was never taken (virtual subtraction).
namespace angio::reconstruction::detail {

/// A frame's line integrals less those of all that is wide and smooth.
struct VesselPicture {
  std::vector<float> line_integrals;    ///< of the contrast medium, with the frame's noise
  std::vector<std::uint8_t> is_vessel;  ///< what stands out of the noise, and two pixels around;
                                        ///< also before what is wide
  double noise = 0.0;                   ///< sd of a pixel of `line_integrals`
};

/// The background of a frame goes on under its vessels:
///
///     b = P + sum_box w (p - P) / sum_box w,    w = 0 where p - b, smoothed over 3 x 3 pixels, is
///     above 3 of its noise, and two pixels around; else 1
///
/// p: line integrals; P: a polynomial of the fourth degree, fitted where nothing stands out; the
/// box, twice over, reaches as far as `widest` to all sides. What is wider than that, bone, has w =
/// 1 all the same: it is background, too, but for its edges, and may hide vessels. b and w take
/// turns, four times.
///
/// @param line_integrals  shape [rows, columns]
/// @param widest  width of the widest vessel [pixels]
/// @param is_subtracted  by a mask run: there is no background
VesselPicture vessels_of(std::vector<float> line_integrals, int columns, int rows, double widest,
                         bool is_subtracted);

}  // namespace angio::reconstruction::detail

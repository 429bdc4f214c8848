#pragma once

#include <cstddef>
#include <vector>

/// The middles of vessels in a picture.
namespace angio::reconstruction::detail {

/// Pixels that the middles of vessels run through.
struct VesselLines {
  int columns = 0, rows = 0;
  std::vector<float> radius;  ///< of the vessel there [pixels], 0 where none runs; shape [rows,
                              ///< columns]
  [[nodiscard]] bool empty() const;
};

/// Ridges of a picture over scales s (Lindeberg, Int. J. Comput. Vis. 30:117, 1998, eq. 50 with
/// gamma = 3/4):
///
///     R(s) = - s^(3/2) l(s),   l: the lesser eigenvalue of the Hessian of the picture, blurred by
///     s
///
/// A vessel of round section, p(x) = 2 a sqrt(r^2 - x^2), has its largest R at s = 0.6664 r, which
/// tells its radius. A line runs where R is the largest across it, and l is `kSure` times its own
/// spread over the picture (of the median absolute value), or `kLikely` times and joined to such;
/// what is shorter than four of its radii is none.
///
/// @param picture  line integrals without what is wide (detail/vessel_pictures.hpp), shape [rows,
///                 columns]
/// @param widest   diameter of the widest vessel [pixels]
VesselLines find_vessel_lines(const std::vector<float>& picture, int columns, int rows,
                              double widest);

/// Leaves out lines where the median radius around is below one [pixels]: those of vessels too
/// thin, or of noise. A throat stays, for the vessel around it is wider.
void leave_out_thin(VesselLines& lines, double least);

/// The lines' pixels, those of one crest together, also across a gap of a pixel.
std::vector<std::vector<std::size_t>> pieces_of(const VesselLines& lines);

/// Leaves out lines shorter than four of their radii, as find_vessel_lines() does: after others
/// were taken out.
void leave_out_short(VesselLines& lines);

}  // namespace angio::reconstruction::detail

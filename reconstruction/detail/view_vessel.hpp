#pragma once

#include <vector>

#include "reconstruction/detail/view_picture.hpp"
#include "reconstruction/views.hpp"

namespace angio::reconstruction::detail {

/// Leaves of a view's lines the one vessel between two places: the path of least cost
///
///     sum over pixels of 1 + (d / 1 pixel)^2,   d: from the nearest line, up to 8 pixels
///
/// It bridges gaps; its pixels carry the radius of the nearest line.
void keep_vessel(ViewPicture& view, const VesselEnds& ends);

/// What other vessels cover.
struct OtherPixels {
  std::vector<char> covered;  ///< one a pixel, 1: another vessel's; empty: they hide too much
  double hidden_part = 0.0;   ///< of the kept vessel's pixels, those within a radius of its line
};

/// The most that is left out of a vessel: beyond, what is left of it tells less than what lies over
/// it spoils.
inline constexpr double kMostHidden = 0.5;

/// The pixels that other vessels cover: those within 1.2 radii and two pixels of their lines. Where
/// a branch leaves the vessel they are no background of it, and where one crosses it they show
/// both. A line that lies wholly nearer to the kept one than 1.33 of its own radii is no other's,
/// but the vessel again, seen broader (in the hollow of a bend); one that leaves it is another's
/// from 0.7 of its radii on.
///
/// Edges of bone have lines, too, but fall to one side only. Of a vessel's line
///
///     max_t min(f(t), f(t + pi)) / max_t f(t) >= 1/2,   f(t) = p - p(1.5 r + 1 pixel away, at t),
///
/// the median around, where the kept vessel is not in the way (after Koller, Gerig, Szekely,
/// Dettwiler, ICCV 1995, p. 864, who take the lesser response of a line's two sides). What edges
/// cover is left out beyond 1.6 radii and two pixels of the kept line alone: they lie behind the
/// vessel, and without the background next to it its width is not told.
///
/// @param all   the view's lines before keep_vessel()
/// @param kept  the view after it
OtherPixels pixels_of_others(const VesselLines& all, const ViewPicture& kept);

}  // namespace angio::reconstruction::detail

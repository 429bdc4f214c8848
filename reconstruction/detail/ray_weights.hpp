#pragma once

#include <vector>

#include "reconstruction/detail/orbit.hpp"

namespace angio::reconstruction::detail {

/// How much of a ray each of its measurements gives. The ray at fan angle g of a source at b is
/// measured again from b + pi - 2 g (at -g), and both a turn later:
///
///     w(b, g) = c(b) / sum_n (c(b + 2 pi n) + c(b + pi - 2 g + 2 pi n))
///
/// so that the measurements of every ray sum to one, on an arc of any length. c rises from 0 to 1
/// over ten degrees at both ends of the arc, as sin^2, so that w has no edge (Noo, Defrise,
/// Clackdoyle, Kudo, Phys. Med. Biol. 47:2525, 2002, eq. 32-35).
///
/// @param across_mm  where the rays pass the plane through the axis that faces the source, u
/// @return shape [size of across_mm]
std::vector<float> ray_weights(const Orbit& orbit, std::size_t frame,
                               const std::vector<double>& across_mm);

}  // namespace angio::reconstruction::detail

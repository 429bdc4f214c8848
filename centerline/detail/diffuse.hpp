#pragma once

#include <optional>

#include "centerline/detail/dip.hpp"

namespace angio::centerline {

/// The narrowing of a vessel that is thin for most of its length, and wide before and behind. The
/// healthy tree that explains most of it is as thin, and calls the ends dilated; a core laboratory
/// takes the ends for healthy. The lines cannot tell which, so it is told, and not listed.
///
/// D_p and D_d are the median diameters over 1.5 diameters of both ends, no more than 1.8 times
/// apart; between them ln D runs straight. Narrowed is the longest stretch that lies below that
/// line by `least_percent` or more wherever it is measured; it counts if it is 0.4 of the vessel
/// and the healthy tree sees less than the shoulder's stenosis at its tightest place.
///
/// @return in doubt (Doubt::diffuse), with the line's diameter for a reference
std::optional<Lesion> find_diffuse(const Known& known, const Vessel& vessel, double least_percent);

}  // namespace angio::centerline

#pragma once

#include <vector>

#include "core/centerline.hpp"

namespace angio::centerline {

/// Where a vessel that runs past another one seems to touch it: their lumens are one there, and the
/// tree has branchings that no anatomy has.
///
/// Two branches leave a line near each other, are as wide as one another, and lie on one straight
/// line; two true branches on opposite sides would do so too (renal arteries), but their common
/// line runs through the middle of the parent, and that of a vessel which only touches it runs
/// beside: farther from the middle than half its radius.
///
/// @return the places [mm]
std::vector<Vec3> find_contacts(const CenterlineTree& tree);

/// How many lines end inside another vessel than the one they left, as where a loop was cut.
int count_cut_ends(const CenterlineTree& tree);

}  // namespace angio::centerline

#pragma once

#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/volume.hpp"

namespace angio::centerline {

/// Warnings of places where two vessels, or the legs of a hairpin, run side by side as one lumen.
///
/// Two round vessels that overlap have a section like an 8: along its longer axis it is narrower
/// between two maxima of its height, and that from both sides. A slit, an oval and what one plaque
/// leaves are not (they have no waist, or on one side only), and a branching has such sections over
/// less than its own width. So a warning is given where the waist is at most 85 % of the lower
/// maximum over at least twice the width of the section.
///
/// @param level_set  that the lines are of [mm], negative inside; its voxels must show the vessels
std::vector<std::string> find_vessels_side_by_side(const CenterlineTree& tree,
                                                   const Volume<float>& level_set);

}  // namespace angio::centerline

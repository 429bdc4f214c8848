#pragma once

#include <optional>
#include <vector>

#include "centerline/detail/lumen_voxels.hpp"

namespace angio::centerline {

/// The chamber that feeds a tree though it is no end of it: an aortic root with its coronaries, cut
/// so short that it stands out of the tree nowhere.
///
/// A chamber is the place where the lumen is at least eight times as wide as the median of every
/// vessel that leaves it (an aortic root of 30 mm and coronaries of 2 to 4 mm; an aneurysm is
/// seldom five times as wide as its vessel), and at least two leave it.
///
/// @param paths  of the tree, from any end to all others
/// @return the voxel of the chamber's wall that is farthest from where the vessels leave it;
/// nothing
///         where no such chamber is
std::optional<int> find_feeding_chamber(const LumenVoxels& lumen,
                                        const std::vector<std::vector<int>>& paths);

}  // namespace angio::centerline

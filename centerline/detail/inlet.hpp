#pragma once

#include <vector>

#include "centerline/detail/fronts.hpp"
#include "centerline/detail/lumen_voxels.hpp"

namespace angio::centerline {

/// An end of the lumen that may be where the blood comes in.
struct InletCandidate {
  int voxel = 0;
  bool is_cut_off = false;  ///< by the border of the volume
  bool is_open = true;      ///< false: an end of the tree, but blood does not come in by it
};

/// The trunk of a tree: the end from which every fork looks as forks do.
///
/// For each candidate the tree is turned so that blood comes from it, and costs
///
///     sum over forks [ 3 min(ln^2(r_in^3 / sum r_out^3), 4) + 1.5 mean(1 - cos(turn)) ]
///         + 3 ln(r_max / r)
///
/// are added up: Murray's law (PNAS 12:207, 1926) within the scatter that real forks have (a
/// factor of 1.5 in the cubes is one standard deviation), daughters that leave forward rather than
/// backward, and a wide end rather than a narrow one. r is the median depth of a stretch between
/// forks, without what lies in a fork and in a cap, so a short trunk counts as much as a long one,
/// and a stenosis little. An end that the volume's border cuts off counts a quarter wider: what
/// feeds the lumen mostly comes from outside.
///
/// @param front  from the first candidate's voxel
/// @return index of the candidate
std::size_t choose_inlet(const LumenVoxels& lumen, const Front& front,
                         const std::vector<InletCandidate>& candidates);

}  // namespace angio::centerline

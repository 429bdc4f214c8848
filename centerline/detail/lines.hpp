#pragma once

#include "centerline/detail/line_shape.hpp"
#include "centerline/detail/skeleton.hpp"
#include "core/centerline.hpp"
#include "core/progress.hpp"

namespace angio::centerline {

/// Lines, and where a vessel was seen round them.
struct TracedLines {
  CenterlineTree tree;
  std::vector<std::vector<char>> is_tube;  ///< 1: a section was seen all round, shape [path][point]
  std::vector<std::vector<char>> is_cut;   ///< 1: the inscribed ball reaches beyond the data, same
};

/// Turns voxel paths into lines through the middle of the lumen, with radii and section areas.
///
/// Each line in turn (the longest first) is moved to the middles of its sections and kept smooth
/// and in the lumen's core, alternately (line_shape.hpp); a later line keeps the points of the line
/// it branches from, leaves it by a smooth curve, and only its own points are moved.
TracedLines trace_lines(const Skeleton& skeleton, const Surroundings& around,
                        const Progress& progress);

}  // namespace angio::centerline

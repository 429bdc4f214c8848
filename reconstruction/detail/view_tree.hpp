#pragma once

#include <cstdint>
#include <vector>

#include "core/centerline.hpp"
#include "core/progress.hpp"
#include "reconstruction/detail/view_picture.hpp"
#include "reconstruction/detail/view_poses.hpp"
#include "reconstruction/views.hpp"

namespace angio::reconstruction::detail {

/// Vessels in space that show as the lines of some views.
struct ViewTree {
  CenterlineTree tree;                  ///< begins at its widest end; empty: no vessel was found
  std::vector<double> explained_parts;  ///< of them that the tree accounts for, [0, 1]
};

/// The least tree that explains the views' lines: grown (detail/tree_growth.hpp) over the places
/// that may be vessel (detail/view_hull.hpp), and smoothed along itself.
///
/// @param views       at least two
/// @param most_bytes  as find_hull() takes them
ViewTree find_view_tree(const std::vector<ViewPicture>& views, std::uint64_t most_bytes,
                        const Progress& progress);

/// A tree, and where the views' C-arms stand against their frames.
struct PosedTree {
  ViewTree found;
  std::vector<ViewPose> poses;
};

/// The tree that three views or more show and their poses (detail/view_poses.hpp), in turn: where
/// the C-arms stand tells which places all views see as vessel, and a tree where the C-arms stand.
/// It ends when a tree does not explain a hundredth more of the views' lines; of two views
/// it is find_view_tree().
PosedTree find_posed_tree(const std::vector<ViewPicture>& views, std::uint64_t most_bytes,
                          const Progress& progress);

/// The one vessel that the views' lines are of (keep_vessel()), from its proximal to its distal
/// end: the path of least cost there, over places up to 2 mm from each view's line, or 4 or 8 where
/// the views do not meet in less.
ViewTree find_view_vessel(const std::vector<ViewPicture>& views,
                          const std::vector<VesselEnds>& ends, std::uint64_t most_bytes);

}  // namespace angio::reconstruction::detail

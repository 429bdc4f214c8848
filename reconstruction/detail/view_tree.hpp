#pragma once

#include <vector>

#include "core/centerline.hpp"
#include "core/progress.hpp"
#include "reconstruction/detail/view_picture.hpp"
#include "reconstruction/views.hpp"

namespace angio::reconstruction::detail {

/// Vessels in space that show as the lines of some views.
struct ViewTree {
  CenterlineTree tree;                  ///< begins at its widest end; empty: no vessel was found
  std::vector<double> explained_parts;  ///< of them that the tree accounts for, [0, 1]
};

/// The least tree that explains the views' lines. A place may be vessel where all views (of four or
/// more all but one) see a line near it. There, paths of least cost
///
///     integral of 1 + sum_v (d_v / max(0.5 mm, r_v / 3))^2 + 4 ln^2(max r_v / min r_v) ds
///
/// d_v: from view v's line; r_v: the radii that the views give the vessel there. From where the
/// vessels are the widest the tree grows by the path that explains the most of what is not yet
/// explained: the second largest of the views' lengths, for one view alone would make a vessel of
/// any line that lies behind a true one. What explains less than 1.25 radii, or 3 mm, of its own in
/// a second view is taken out.
///
/// @param views  at least two
ViewTree find_view_tree(const std::vector<ViewPicture>& views, const Progress& progress);

/// The one vessel that the views' lines are of (keep_vessel()), from its proximal to its distal
/// end: the path of least cost there, over places up to 2 mm from each view's line, or 4 or 8 where
/// the views do not meet in less.
ViewTree find_view_vessel(const std::vector<ViewPicture>& views,
                          const std::vector<VesselEnds>& ends);

}  // namespace angio::reconstruction::detail

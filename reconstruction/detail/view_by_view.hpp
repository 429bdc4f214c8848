#pragma once

#include <vector>

#include "core/centerline.hpp"
#include "core/progress.hpp"
#include "reconstruction/detail/view_picture.hpp"
#include "reconstruction/tree_fit.hpp"

namespace angio::reconstruction::detail {

/// How far the views' rays to the same places of a tree pass each other [mm]: the median over its
/// points, each seen on the nearest line of every view.
double view_skew(const std::vector<ViewPicture>& views, const CenterlineTree& tree);

/// Hearts beat and breathe between views, so that no line in space lies on the vessel in all of
/// them. Each view's line is fitted where that view sees the vessel (fit_tree() to one frame, which
/// tells place and width across its rays); the line in space is where the views' rays to the same
/// place of the vessel pass nearest to each other, and its radius
///
///     ln r = sum_v w_v ln r_v / sum_v w_v,   w_v = 1 / (sd_v / r_v)^2
///
/// that of a circle of the area of the ellipse that two views at right angles tell. Where a view
/// has the vessel wider than 1.5 times the narrowest one's, something lies before or behind it, and
/// it does not count.
///
/// @param views  where they were found to be
/// @param start  lines that all views see within 4 mm of their own
TreeFit measure_view_by_view(const RotationalRun& run, double air,
                             const std::vector<ViewPicture>& views, const CenterlineTree& start,
                             const TreeFitOptions& options, const Progress& progress);

}  // namespace angio::reconstruction::detail

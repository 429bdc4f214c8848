#pragma once

#include "core/progress.hpp"
#include "reconstruction/tree_fit.hpp"

namespace angio::reconstruction::detail {

/// Cuts a fitted tree where its vessels end: lines reach out of a vessel's end by their blur, and
/// the tube fitted there has no radius to speak of. The fit stays as it is between the ends.
void cut_ends(TreeFit& fit);

/// Fits a tree (fit_tree()), cut where its vessels end: with coarse nodes until nothing more is
/// cut, then as fine as is due.
TreeFit fit_to_ends(RotationalRun run, double air, CenterlineTree tree,
                    const TreeFitOptions& options, const Progress& progress);

}  // namespace angio::reconstruction::detail

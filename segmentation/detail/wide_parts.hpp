#pragma once

#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {

/// Leaves the vessels of a lumen that are no wider than options.max_diameter_mm = 2 R. Taken out is
/// what a ball of radius R fits into once gaps under 2 c = 0.6 R are closed, as those between the
/// muscles inside a heart's chamber, and R / 4 more along the branches that leave it:
///
///     K = {phi < c} shrunk by c,    C = {d_K <= -R},    phi' = max(phi, 5/4 R - d_C)
///
/// with the signed distances phi of the lumen, d_K of the closed lumen, d_C of the balls' centres.
/// What remains falls into pieces: those with a seed are kept, or the largest where none is given.
/// Beside a chamber closed gaps cost a vessel its side: what a ball of radius R does not fit into
/// without them, within R / 2 of the kept pieces, is given back.
/// A vessel ends at its mouth in a face that is bent as the ball is.
/// Source: Serra, Image Analysis and Mathematical Morphology, 1982, ch. II: closing, opening.
///
/// Without max_diameter_mm nothing is changed.
///
/// @throws InputError if nothing is left, or no lumen at a seed
void leave_out_wide_parts(const SegmentationOptions& options, Segmentation& segmentation);

}  // namespace angio::segmentation::detail

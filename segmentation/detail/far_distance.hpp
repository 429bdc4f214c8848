#pragma once

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// Continues a signed distance that ends at a band beside the surface, by the nearest of the
/// closest points that were found on every second voxel: within half a voxel of the truth.
///
/// @param distance  [mm], exact within the band and at least as long beyond; continued
/// @param band_mm   at which it ends
/// @param reach_mm  at which the result ends outside; inside it has no end
void continue_distance(Volume<float>& distance, double band_mm, double reach_mm);

}  // namespace angio::segmentation::detail

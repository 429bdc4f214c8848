#pragma once

#include "core/volume.hpp"
#include "segmentation/detail/components.hpp"

namespace angio::segmentation::detail {

/// The piece at a user's seed, or at the nearest voxel within 1 mm.
/// @throws InputError if there is none
int piece_at_seed(const Components& pieces, const VolumeGeometry& geometry, const Vec3& seed);

}  // namespace angio::segmentation::detail

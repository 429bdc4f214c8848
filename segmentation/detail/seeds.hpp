#pragma once

#include <cstddef>
#include <optional>

#include "core/volume.hpp"
#include "segmentation/detail/components.hpp"

namespace angio::segmentation::detail {

/// The piece at a user's seed, or at the nearest voxel within 1 mm.
/// @throws InputError if there is none
int piece_at_seed(const Components& pieces, const VolumeGeometry& geometry, const Vec3& seed);

/// The voxel that a place in LPS [mm] lies in, none if it is outside the grid.
std::optional<std::size_t> voxel_at(const VolumeGeometry& grid, const Vec3& place);

}  // namespace angio::segmentation::detail

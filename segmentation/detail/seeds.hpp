#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/tube_axes.hpp"

namespace angio::segmentation::detail {

/// The piece at a user's seed, or at the nearest voxel within 1 mm.
/// @throws InputError if there is none
int piece_at_seed(const Components& pieces, const VolumeGeometry& geometry, const Vec3& seed);

/// The places on axes that are about as bright as the tube that a seed lies in, or as the seed
/// where it lies in none: they tell the level of the blood that the user means, however much bone
/// there is. All places where there are no seeds, or none is so bright.
std::vector<TubeAxis> axes_at_seeds(std::vector<TubeAxis> axes, const Volume<float>& volume,
                                    const std::vector<Vec3>& seeds);

/// The voxel that a place in LPS [mm] lies in, none if it is outside the grid.
std::optional<std::size_t> voxel_at(const VolumeGeometry& grid, const Vec3& place);

}  // namespace angio::segmentation::detail

#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "core/volume.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/tube_axes.hpp"

namespace angio::segmentation::detail {

struct SeedInNoVessel : InputError {
  using InputError::InputError;
};

/// The piece at a user's seed, or at the nearest voxel within 1 mm.
/// @throws SeedInNoVessel if there is none
/// @throws InputError if the seed lies outside the volume
int piece_at_seed(const Components& pieces, const VolumeGeometry& geometry, const Vec3& seed);

/// The places on axes that may be blood if the tubes that seeds lie in are: none whose contrast is
/// over twice that of the brightest of these (intensity > intensity there + contrast there), as
/// bone's is. All places where no seed lies in a tube; thin vessels are darker than their blood.
///
/// @param seeds  in LPS [mm]
std::vector<TubeAxis> axes_of_seeds(std::vector<TubeAxis> axes, const VolumeGeometry& grid,
                                    const std::vector<Vec3>& seeds);

/// The voxel that a place in LPS [mm] lies in, none if it is outside the grid.
std::optional<std::size_t> voxel_at(const VolumeGeometry& grid, const Vec3& place);

}  // namespace angio::segmentation::detail

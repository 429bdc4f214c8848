#pragma once

#include <array>
#include <cstdint>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// The place (i, j, k) of a voxel in its grid.
std::array<int, 3> voxel_of(const VolumeGeometry& grid, std::size_t v);

/// Adds the shells of partial volume to objects: voxels within two blurs and a voxel (2.6 voxels)
/// that are reached on a falling way, which ends at the valley before a vessel.
///
/// @param tolerance  by which the way may rise: noise
/// @param kept       1: not to be taken, or no values
void add_shells(Volume<std::uint8_t>& mask, const Volume<float>& denoised, float tolerance,
                const Volume<std::uint8_t>& kept = {});

/// The volume with the local background, what is outside of the mask and below `half`, in its
/// place.
Volume<float> take_out(const Volume<float>& volume, const Volume<std::uint8_t>& mask, float half);

}  // namespace angio::segmentation::detail

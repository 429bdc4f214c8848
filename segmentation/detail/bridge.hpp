#pragma once

#include <cstdint>
#include <vector>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// Joins what a threshold cut apart: between pieces of the inside that the tree connects, the
/// cheapest way through the tree (length times one plus how far outside the level is there) is made
/// inside, as thin as the grid can hold.
///
/// @param level         negative inside; changed along the bridges
/// @param tree          connected voxels that the vessels run through, on the same grid
/// @param least_volume  of a piece that is worth a bridge [mm^3]
/// @return the middle of each bridge, LPS [mm]
std::vector<Vec3> bridge_pieces(Volume<float>& level, const Volume<std::uint8_t>& tree,
                                double least_volume);

/// The value of the nearest voxel at each voxel of another grid with the same axes.
Volume<std::uint8_t> resample_nearest(const Volume<std::uint8_t>& mask,
                                      const VolumeGeometry& geometry);

}  // namespace angio::segmentation::detail

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/components.hpp"

namespace angio::segmentation::detail {

/// Joins what a threshold cut apart: between pieces of the inside that the tree connects, the
/// cheapest way through the tree (length times one plus how far outside the level is there) is made
/// inside, as thin as the grid can hold.
///
/// @param level         negative inside; changed along the bridges
/// @param tree          connected voxels that the vessels run through, on the same grid; of several
///                      trees all
/// @param least_volume  of a piece that is worth a bridge [mm^3]
/// @param are_several   trees: pieces that cannot be reached from the largest are joined, too
/// @return the middle of each bridge, LPS [mm]
std::vector<Vec3> bridge_pieces(Volume<float>& level, const Volume<std::uint8_t>& tree,
                                double least_volume, bool are_several);

/// The share of the tree in each piece of a finer grid's inside.
///
/// @param ratio  steps of the pieces' grid for each voxel of the tree
/// @return voxels of the pieces' grid, shape [piece_count + 1]
std::vector<std::size_t> tree_in_pieces(const Pieces& pieces, const Volume<std::uint8_t>& tree,
                                        const std::array<int, 3>& ratio);

/// The value of the nearest voxel at each step of a finer grid.
Volume<std::uint8_t> refine_mask(const Volume<std::uint8_t>& mask, const VolumeGeometry& geometry,
                                 const std::array<int, 3>& ratio);

}  // namespace angio::segmentation::detail

#pragma once

#include <cstdint>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// The distance from each set voxel to the nearest that is not [mm], 0 outside; the volume's border
/// counts as set beyond. Exact between voxels' centres (Maurer, Qi, Raghavan, IEEE PAMI 25(2),
/// 2003).
Volume<float> depth_in(const Volume<std::uint8_t>& mask);

/// Sets what the mask goes around in a plane of voxels, along any of the grid's axes.
/// @param most_mm2  larger holes stay
void fill_holes(Volume<std::uint8_t>& mask, double most_mm2);

}  // namespace angio::segmentation::detail

#pragma once

#include <cstdint>
#include <string>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// Tells of vessels that the enhancement shows and that have no lumen within a voxel. Pieces,
/// joined by corners, that span six voxels or more count: noise that passes the threshold of single
/// voxels (kNoiseDeviations) has no such length.
///
/// @param seen       1 on vessels
/// @param level_set  the lumen's, on any grid
/// @return a warning with their number and a place; empty if there is none
std::string warn_of_thin_vessels(const Volume<std::uint8_t>& seen, const Volume<float>& level_set);

}  // namespace angio::segmentation::detail

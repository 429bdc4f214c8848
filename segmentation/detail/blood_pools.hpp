#pragma once

#include <cstdint>

#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {

/// Why a voxel is a candidate for the tree.
constexpr std::uint8_t kBridge = 1;  ///< it joins a tube, but may be no lumen
constexpr std::uint8_t kLumen = 2;   ///< its level is that of lumen

/// Adds wide bodies of blood, which no scale shows as tubes: chambers of the heart, wide aortas,
/// aneurysms.
///
/// A body is where most voxels within about 4 mm come at least 65 % of the way from tissue to
/// blood; it reaches as far as that neighbourhood and as the half level between the two. One with a
/// rim brighter than its inside, as cortex around marrow, is bone and left out.
void add_pools(const Volume<float>& smoothed, const BloodLevel& level,
               const SegmentationOptions& options, Volume<std::uint8_t>& mask);

}  // namespace angio::segmentation::detail

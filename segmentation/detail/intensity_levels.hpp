#pragma once

#include <optional>

#include "core/volume.hpp"
#include "segmentation/detail/fields.hpp"

namespace angio::segmentation::detail {

/// The intensity of pure lumen and of pure background around each place.
struct IntensityLevels {
  CoarseField lumen;
  CoarseField background;
  float lumen_overall = 0.0f;
  float background_overall = 0.0f;
};

/// Tells both levels from a boundary that is roughly known.
///
/// The background B is the local mean of a ring around the vessel, other bright things left out.
/// The lumen L is the local mean over voxels deep inside, each freed of what the blur mixed in:
///
///     L = B + (I - B) / S,    weight S^8
///
/// Means are spread by normalised convolution, from wide kernels to narrow ones: a narrow vessel,
/// where S never gets near 1, takes L from the wider vessel beside it.
/// Source: Knutsson & Westin, "Normalized and differential convolution", CVPR 1993,
///         doi:10.1109/CVPR.1993.341081.
///
/// @param distance  d [mm], signed, on the volume's grid; its ends at both sides may lie as near as
///                  edge_mm + 3 mm
/// @param share     S: the part of each voxel inside, blurred
/// @param edge_mm   half the width of the blurred edge
/// @param blood_half_level  what lies below it is background in any case
IntensityLevels intensity_levels(const Volume<float>& volume, const Volume<float>& distance,
                                 const Volume<float>& share, double edge_mm,
                                 std::optional<float> blood_half_level = std::nullopt);

}  // namespace angio::segmentation::detail

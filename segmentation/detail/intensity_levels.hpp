#pragma once

#include <optional>

#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/fields.hpp"

namespace angio::segmentation::detail {

/// The intensity of pure lumen and of pure background around each place.
struct IntensityLevels {
  CoarseField lumen;
  CoarseField background;
  CoarseField lift;  ///< of the background above what is there, by the walls of wide vessels
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
/// Where blood and tissue are told by even places (L_b, T) a wide vessel's background is no darker
/// than
///
///     T - (L_b - T) / 4,    T: the tissue's level
///
/// though it lies beside lung or air: its own wall, of 0.15 radii (an aorta's: 1.5 to 2 mm) and the
/// fat on it, is what ends the blood there. From a radius of 5 voxels on that is seen;
/// below 3 it is not, and thin vessels in lung have lung for background.
///
/// @param distance  d [mm], signed, on the volume's grid; its ends at both sides may lie as near as
///                  edge_mm + 3 mm
/// @param share     S: the part of each voxel inside, blurred
/// @param edge_mm   half the width of the blurred edge
/// @param blood     what lies below its half level is background in any case
IntensityLevels intensity_levels(const Volume<float>& volume, const Volume<float>& distance,
                                 const Volume<float>& share, double edge_mm,
                                 const std::optional<BloodLevel>& blood = std::nullopt);

}  // namespace angio::segmentation::detail

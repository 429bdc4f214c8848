#pragma once

#include <optional>

#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/fields.hpp"

namespace angio::segmentation::detail {

inline constexpr double kEdgeBlurs = 3.0;  ///< half width of a blurred edge, in standard deviations

/// The intensity of pure lumen and of pure background around each place.
struct IntensityLevels {
  CoarseField lumen;
  CoarseField background;
  CoarseField lift;  ///< of the background above what is there, by the vessels' walls
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
/// In computed tomography most arteries lie in fat, F, which is darker than their walls, W = 50 HU
/// (as muscle). Blurred by s, an edge from L over a wall of thickness t to F has at the lumen's
/// border the value L / 2 + W (P - 1/2) + F (1 - P), P = Phi(t / s): as if the background were
///
///     B = F + (W - F) erf(t / (sqrt(2) s)),    t = 0.4 radii, at least 0.55 mm
///
/// t is a healthy coronary artery's (0.75 mm, of 0.55 to 1.0, by magnetic resonance: Fayad et al.,
/// Circulation 102, 2000, 506-510); a stenosis has no thinner one. Half way to fat lies in the
/// wall, and a lumen of 2.6 mm came out 35 % too wide. It is done where the volume shows
/// a body in Hounsfield units (fat from -130 to -70 and soft tissue from 20 to 130, each a
/// fiftieth of it, and fat at least half as common as what lies between) and the blood has 150 to
/// 1200; it fades out from -120 to -250, where there is more lung or air around than fat.
///
/// @param distance  d [mm], signed, on the volume's grid; its ends at both sides may lie as near as
///                  edge_mm + 3 mm
/// @param share     S: the part of each voxel inside, blurred
/// @param edge_mm   half the width of the blurred edge: kEdgeBlurs standard deviations
/// @param blood     what lies below its half level is background in any case
IntensityLevels intensity_levels(const Volume<float>& volume, const Volume<float>& distance,
                                 const Volume<float>& share, double edge_mm,
                                 const std::optional<BloodLevel>& blood = std::nullopt);

}  // namespace angio::segmentation::detail

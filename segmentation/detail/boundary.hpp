#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {

/// The lumen's sub-voxel boundary.
struct Boundary {
  Volume<float> level_set;  ///< signed distance [mm], negative inside
  double lumen_intensity = 0.0;
  double background_intensity = 0.0;
  Vec3 blur_sd_mm;                   ///< of the scanner's blur along i, j, k
  bool blur_is_told = false;         ///< false: the image did not tell it
  double clipped_share = 0.0;        ///< of the lumen's voxels: as bright as any can be
  std::vector<Vec3> bridges_lps_mm;  ///< places too narrow for the voxels, kept open
};

/// What the boundary is sought in; all on one grid around the tree.
struct BoundaryInput {
  const Volume<float>& image;        ///< as it was scanned
  const Volume<float>& denoised;     ///< smoothed by denoising_mm
  const Volume<std::uint8_t>& tree;  ///< the vessels' voxels
  double denoising_mm = 0.0;
  double noise_share = 0.0;  ///< standard deviation / contrast
  bool are_several = false;  ///< trees, each to be kept
  /// Where vessels lie in several tissues: what is below the half level is no lumen but beside the
  /// tree.
  std::optional<BloodLevel> blood = std::nullopt;
};

/// Finds where a vessel's voxels are half lumen, half background, by local intensities, roughly at
/// first:
///
///     F = (I - T) / (L - B),    T = B + (L - B) / 2
///
/// L is the mean of voxels deep inside the vessel, B that of voxels around it, both spread by
/// normalised convolution from wide kernels to narrow ones, so that a narrow place, whose own peak
/// is blurred, takes L from the vessel beside it. T stays below the local peak, so that no vessel
/// is lost that the tree holds. From there the boundary is fitted to the image (fit_edges).
Boundary find_boundary(const BoundaryInput& input, const SegmentationOptions& options,
                       const Progress& progress);

/// Finds the surface that labels were most likely made from: where its voxels' centres lie inside,
/// a label is 1. Such a label is, in the mean over where the grid may lie, the part of the voxel
/// inside; so the same fit is made without blur, with the grid's steps as noise. Staircases go,
/// volumes stay.
///
/// @param labels  1 inside, in the wanted pieces only
Volume<float> find_label_boundary(const Volume<std::uint8_t>& labels,
                                  const SegmentationOptions& options, const Progress& progress);

}  // namespace angio::segmentation::detail

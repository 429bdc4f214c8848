#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/tube_axes.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {

/// Where the vessels are, voxel by voxel; the boundary is found later.
struct VesselTree {
  Volume<std::uint8_t> mask;       ///< 1 in the kept tree, on the input's grid
  Volume<std::uint8_t> seen;       ///< 1 on thin vessels, in the tree or left out without a word
  std::vector<Vec3> seeds_lps_mm;  ///< the seeds that were used, or one in each piece
  double contrast = 0.0;           ///< typical, of lumen against background [intensity]
  double noise = 0.0;              ///< standard deviation from voxel to voxel [intensity]
  /// Of blood and tissue, where vessels also lie in something darker: whatever is below their half
  /// level is no lumen but in thin vessels.
  std::optional<BloodLevel> blood;
  std::vector<std::string> warnings;
};

/// Finds the connected trees of bright tubes.
///
/// A voxel belongs to it if it is above the half level of the tubes nearby, I - C / 2 averaged with
/// weight C^2 (C: find_tubes), and above the half level between blood and tissue or, but among
/// organs (is_even), beside a tube; or if C itself is high there (among organs at a quarter of the
/// way to blood or more), which bridges narrow places whose peak is below the half level; or
/// if it lies in a pool (add_pools). Of the connected pieces, the one with the longest trunks in it
/// is kept, or that with most contrast of those whose trunks are at least half as long and less
/// than 10 mm shorter; where none has 10 mm of them, that with most contrast and, where no trunk is
/// seen, those with a fifth of it; or those with a seed in them; the couch under the patient, which
/// is the same in all slices, is none.
///
/// @param trunks  axes of wide tubes that are sure to hold blood, or none
/// @throws InputError if there is no vessel, or a seed lies in none
VesselTree find_vessel_tree(const Volume<float>& volume, const BloodLevel& level,
                            const std::vector<TubeAxis>& trunks, const SegmentationOptions& options,
                            const Progress& progress);

/// Standard deviation [intensity] of the noise from voxel to voxel, from the median absolute
/// second difference along i, j, k.
double noise_deviation(const Volume<float>& volume);

/// Standard deviation [mm] of the smoothing that brings noise to about 5 % of the contrast; 0 if
/// it is below that already.
double denoising_sigma(const Volume<float>& volume, double noise, double contrast);

}  // namespace angio::segmentation::detail

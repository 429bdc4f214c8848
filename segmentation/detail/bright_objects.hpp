#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/tube_axes.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {

/// Bone, calcification and metal brighter than the vessels.
struct BrightObjects {
  Volume<float> image_without;  ///< the image without them; empty: there are none
  std::vector<std::string> warnings;
};

/// Finds objects that are brighter than the tubes of the volume by half their contrast and are no
/// tubes themselves.
///
/// L and C are the 0.9 quantiles of intensity and contrast on tube axes, by length times C^2.
/// Pieces above L + 0.35 C that reach L + C / 2 count, unless a seed lies in them, or a tube axis
/// runs through half their extent. They become local background, with their shells of partial
/// volume: voxels within two blurs and a voxel (2.6 voxels) that are reached on a falling way,
/// which ends at the valley before a vessel. Without a tube that voxels show in full, nothing is
/// taken for bright.
///
/// Pieces in a vessel's wall are calcified plaque, and darkened instead (plaque.hpp). For them, L
/// and C are those of blood where they are known; else 0.75 quantiles, and C counts in the weights
/// for no more than its median: plaque's own is the greatest.
///
/// @param axes   of the volume (find_tube_axes)
/// @param known  blood's level, where even vessels tell it; else not told
BrightObjects find_bright_objects(const Volume<float>& volume, const std::vector<TubeAxis>& axes,
                                  const BloodLevel& known, const SegmentationOptions& options);

}  // namespace angio::segmentation::detail

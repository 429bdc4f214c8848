#pragma once

#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/tube_axes.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::segmentation::detail {

/// A scan in which nothing as bright as blood is seen but blood, as far as that can be told.
struct VesselImage {
  Volume<float> without;         ///< bone, calcification and metal; empty: there were none
  BloodLevel level;              ///< of blood and tissue
  std::vector<TubeAxis> trunks;  ///< wide tubes that are sure to hold blood; none: not told
  std::vector<std::string> warnings;
};

/// Takes out bones and organs (find_bones), then what is brighter than blood (find_bright_objects),
/// unless the options say not to.
///
/// @param axes  that may be blood's
VesselImage find_vessel_image(const Volume<float>& scanned, std::vector<TubeAxis> axes,
                              const SegmentationOptions& options, const Progress& progress);

}  // namespace angio::segmentation::detail

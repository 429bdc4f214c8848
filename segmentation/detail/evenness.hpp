#pragma once

#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"

namespace angio::segmentation::detail {

/// How alike the voxels around each place are: blood with contrast is mixed, and as even as the
/// scanner's noise lets it be; bone is marrow, cortex and struts.
struct Evenness {
  Volume<float> mean;       ///< of a Gaussian neighbourhood
  Volume<float> deviation;  ///< standard deviation in it
  float of_tissue = 0.0f;   ///< the commonest deviation among voxels of soft tissue: noise
  double reach_mm = 0.0;    ///< standard deviation of the neighbourhood
  /// Whether a place is as even as tissue is.
  [[nodiscard]] bool is_even(std::size_t v) const;
  /// How far from its border a body shows nothing but itself [mm].
  [[nodiscard]] double depth_mm() const;
};

/// @param level  tells soft tissue, and the range of values that count
Evenness find_evenness(const Volume<float>& volume, const BloodLevel& level);

}  // namespace angio::segmentation::detail

#pragma once

#include "core/volume.hpp"
#include "segmentation/detail/blood_level.hpp"

namespace angio::segmentation::detail {

/// How alike the voxels around each place are: blood with contrast is mixed, and as even as the
/// scanner's noise lets it be; bone is marrow, cortex and struts.
struct Evenness {
  Volume<float> mean;        ///< of a Gaussian neighbourhood
  Volume<float> unevenness;  ///< standard deviation in it over that of the noise around
  float of_tissue = 0.0f;    ///< the commonest deviation among voxels of soft tissue: noise
  double reach_mm = 0.0;     ///< standard deviation of the neighbourhood
  /// Whether a place is as even as the tissue around is.
  [[nodiscard]] bool is_even(std::size_t v) const;
  /// How far from its border a body shows nothing but itself [mm].
  [[nodiscard]] double depth_mm() const;
};

/// Noise is not the same all over: shoulders have several times a head's. Around each place it is
/// the deviation of the quietest soft tissue within some 3 cm, from the whole volume's to 1.75
/// times that.
///
/// @param level  tells soft tissue, and the range of values that count
Evenness find_evenness(const Volume<float>& volume, const BloodLevel& level);

}  // namespace angio::segmentation::detail

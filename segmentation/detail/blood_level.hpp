#pragma once

#include <utility>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/tube_axes.hpp"

namespace angio::segmentation::detail {

/// What tells contrast-filled blood from the tissues around it.
struct BloodLevel {
  float lumen = 0.0f;    ///< of pure blood
  float tissue = 0.0f;   ///< of the brightest tissue that is common and no blood
  bool is_told = false;  ///< false: the volume does not show it
  [[nodiscard]] float contrast() const { return lumen - tissue; }
  [[nodiscard]] float half() const { return 0.5f * (lumen + tissue); }
};

/// Tells the level of blood from the axes of tubes with a full profile, and that of tissue from the
/// volume's histogram.
///
/// The lumen is the median over the axes, weighted with their length and with their contrast
/// squared, which counts for no more than its own median (else bone and metal would have their
/// say). Of the histogram's modes, each with 2 % of the voxels or more and a valley to the next,
/// the highest below the lumen, or clearly below a quarter of the axes, is tissue, and the lumen is
/// then the median of the axes that are brighter: those that are darker are thin vessels in lung. A
/// mode that a quarter of the axes lie in, within its own width and nearer than the next one below,
/// is blood's own. So a vessel beside lung and muscle has muscle's level to stand out from,
/// although lung is farther from its own.
BloodLevel find_blood_level(const std::vector<TubeAxis>& axes, const Volume<float>& volume,
                            double noise);

/// A value that a share of the weights lies below. Sorts the values.
float weighted_quantile(std::vector<std::pair<float, double>>& values, double share);

}  // namespace angio::segmentation::detail

#pragma once

#include <utility>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/tube_axes.hpp"

namespace angio::segmentation::detail {

/// What tells contrast-filled blood from the tissues around it.
struct BloodLevel {
  float lumen = 0.0f;        ///< of pure blood
  float tissue = 0.0f;       ///< of the brightest tissue that is common and no blood
  bool is_told = false;      ///< false: the volume does not show it
  bool is_even = false;      ///< told by vessels that are wide enough to be seen as even inside
  bool is_of_pools = false;  ///< told by what is even, though brighter tubes are there
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

/// The same where tubes of blood are wide enough to be seen as even inside: the lumen is the median
/// of those above the half level of before, by length, and tissue the brightest mode of the even
/// places below half that is common: it has a quarter of the voxels of the commonest within three
/// times its way down from blood (fat and muscle, not air and lung).
///
/// Where less than 10 mm of such tubes are there (a slab across the body), 20 ml or more of even
/// places above half (a heart) tell the lumen as well as they: their commonest level.
///
/// Where nothing even is that bright, the tubes were those of bones, or of veins with a bolus that
/// has not mixed yet. Blood is then the largest pool of even places: a mode of 20 ml or more, below
/// the half level of before, that is brighter than the brightest common tissue and has less than a
/// quarter of its volume. The same where such a pool is there and the tissue of before is above
/// half of it: blood was taken for tissue. But kidneys are no blood: they have fewer even tubes at
/// their level than there are above it, at up to four times their contrast (metal has more). Where
/// there is no such pool either (a head, whose bones are the brightest tubes), blood is the even
/// tubes that stand out of the brightest common tissue by a fifth of its way to the half level of
/// before: their median, if they are 10 mm long.
///
/// @param axes       even parts of wide tubes
/// @param even       means of even neighbourhoods in the volume
/// @param place_mm3  volume that each of them stands for [mm^3]
/// @param rough      find_blood_level's
/// @return not told if there are no such tubes and no pool
BloodLevel find_even_level(const std::vector<TubeAxis>& axes, std::vector<float> even,
                           double place_mm3, const BloodLevel& rough);

/// A value that a share of the weights lies below. Sorts the values.
float weighted_quantile(std::vector<std::pair<float, double>>& values, double share);

}  // namespace angio::segmentation::detail

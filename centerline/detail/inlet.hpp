#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "centerline/detail/fronts.hpp"
#include "centerline/detail/lumen_voxels.hpp"

namespace angio::centerline {

/// An end of the lumen that may be where the blood comes in.
struct InletCandidate {
  int voxel = 0;
  bool is_cut_off = false;  ///< by the border of the volume
  bool is_open = true;      ///< false: an end of the tree, but blood does not come in by it
  bool is_tip = false;      ///< a closed one of a surface whose other vessels end in rims or caps
  double opening = std::numeric_limits<double>::infinity();  ///< radius of its rim or tip [mm]
};

struct InletChoice {
  std::size_t best = 0;              ///< index of the candidate
  std::optional<std::size_t> rival;  ///< the next best, where its cost is less than 1 higher
};

/// The trunk of a tree: the end from which every fork looks as forks do.
///
/// For each candidate the tree is turned so that blood comes from it, and costs
///
///     sum over forks min(3, m + 3 mean((turn - turn_M)^2)) + 2 ln(r_max / r),
///     m = 3 ln^2(r_in^3 / sum r_out^3)
///
/// are added up, and m, at most 6, for the tree as one fork, which aneurysms at its forks do not
/// change (half of it where there is but one fork): Murray's law of radii (PNAS 12:207, 1926) and
/// of angles (J Gen Physiol 9:835, 1926: cos turn_M = (r_p^4 + r^4 - r_q^4) / (2 r_p^2 r^2), r_p^3
/// = sum r_out^3, r_q^3 = r_p^3 - r^3), each within the scatter of real forks (one standard
/// deviation: a factor of 1.5 in the cubes, 0.41 rad), and a wide end rather than a narrow one. A
/// fork off by 2.4 standard deviations is as bad as any: an aneurysm, or vessels that touch, must
/// not outvote the others. r is the median depth of a stretch between forks, without what lies in a
/// fork and in a cap, so a short trunk counts as much as a long one, and a stenosis little. In the
/// last term r is that of the half that ends at the tip: an end is as wide as its vessel is there,
/// not as the sac that it comes from. An end that the volume's border cuts off counts a quarter
/// wider: what feeds the lumen mostly comes from outside. One with an open rim is as wide as that,
/// if the rim is not half as wide again as its vessel: a hole in the wall of a wide vessel is a
/// small end. Where there is but one vessel, open at both ends, r is that of its rims.
///
/// Where the two ends that cost least are those of one arch (a vessel of 10 mm or more whose limbs
/// are three radii long or more and seen under less than 75 degrees from its shoulder), that of the
/// limb that is longer by a quarter costs 2 more: an aorta ascends over a shorter way than it
/// descends.
///
/// Where a surface has two rims or caps or more, a closed tip is a candidate only where it is wider
/// by a quarter than every one of them (caps count as cut off, so by more): what was cut off is the
/// trunk, rather.
///
/// @param front  from the first candidate's voxel
InletChoice choose_inlet(const LumenVoxels& lumen, const Front& front,
                         const std::vector<InletCandidate>& candidates);

}  // namespace angio::centerline

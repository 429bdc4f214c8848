#include "centerline/detail/doubt.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace angio::centerline {
namespace {

/// What is wider, in a large tree or one where vessels touch, is more often the heart, narrow at
/// its valves, than an aorta [mm of diameter].
constexpr double kWidestTreated = 25.0;

/// Of its healthy diameter a vessel is to be seen beyond a stenosis.
constexpr double kSeenBeyond = 0.5;

/// Whether a line begins or ends in a dip, and is tightest there: no healthy vessel is seen beyond
/// it, and where an image ends its edge or fading signal look the same.
/// @param edge    of the dip, towards that end
/// @param end_mm  abscissa of the line's end
bool lies_at(double end_mm, std::size_t edge, const Known& known, const Dip& dip) {
  const double healthy = known.reference.diameter[dip.tightest];
  const std::vector<double>& s = known.path.abscissa;
  return std::abs(s[edge] - end_mm) < kSeenBeyond * healthy &&
         std::abs(s[dip.tightest] - end_mm) < healthy;
}

/// Whether a line ends at a wall and not at an opening or a flat cut: the ball at its tip is under
/// half as wide as in the dip, or hardly anything. There a surface, too, ends where its image or
/// its maker left off.
bool is_closed_at(std::size_t tip, const Known& known, const Dip& dip) {
  constexpr double kClosed = 0.5, kNothing = 0.1;  // of the dip's and of the healthy radius
  const std::vector<double>& radius = known.path.inscribed_radius;
  const double healthy = 0.5 * known.reference.diameter[dip.tightest];
  return radius[tip] < std::max(kClosed * radius[dip.tightest], kNothing * healthy);
}

/// Whether the lumen to one side of a dip is no tube, as in an organ or a sac: within two healthy
/// diameters the largest circle fills less than two fifths of the section (as in an ellipse 2.5
/// times as wide as high), in the median.
bool lies_beside_no_tube(const Known& known, const Dip& dip) {
  constexpr double kBeside = 2.0, kLeastShare = 0.4;
  const std::vector<double>&s = known.path.abscissa, &radius = measured_radius(known.path);
  const double reach = kBeside * known.reference.diameter[dip.tightest];
  const auto is_no_tube = [&](double low, double high) {
    std::vector<double> shares;
    for (std::size_t i = 0; i < s.size(); ++i)
      if (s[i] >= low && s[i] <= high && known.path.equivalent_radius[i] > 0.0)
        shares.push_back(std::pow(radius[i] / known.path.equivalent_radius[i], 2.0));
    if (shares.empty()) return false;
    const auto middle = shares.begin() + std::ptrdiff_t(shares.size() / 2);
    std::nth_element(shares.begin(), middle, shares.end());
    return *middle < kLeastShare;
  };
  return is_no_tube(s[dip.first] - reach, s[dip.first]) ||
         is_no_tube(s[dip.last], s[dip.last] + reach);
}

/// Whether the line has come through the heart, or out of one wide vessel into one beside it: what
/// is too wide for a balloon is half as wide as it should be, or as it was before and is again.
bool lies_beyond_the_heart(const Known& known, const Dip& dip) {
  constexpr double kNarrow = 0.5;
  double widest = 0.0, tightest = 0.0;  // of what is too wide, and behind it [mm]
  for (std::size_t i = 0; i < dip.first; ++i) {
    if (known.reference.diameter[i] > kWidestTreated && known.percent(i) > 100.0 * kNarrow)
      return true;
    const double diameter = 2.0 * known.path.equivalent_radius[i];
    if (diameter > kWidestTreated && tightest < kNarrow * widest) return true;
    if (diameter > widest && diameter > kWidestTreated)
      widest = tightest = diameter;
    else
      tightest = std::min(tightest, diameter);
  }
  return false;
}

/// Whether nothing is measured beyond a dip on one side, and on the other an aneurysm lies before
/// the healthy vessel: over more than half a healthy diameter the lumen is 1.3 times as wide,
/// before a diameter of healthy vessel is reached. What reaches over an aneurysm tells less of the
/// width beyond: odds of seven to one are asked for.
bool lies_beyond_aneurysm(const Known& known, const Vessel& vessel, const Dip& dip,
                          const Lesion& lesion) {
  constexpr double kLeastEvidence = 2.0, kWide = 1.3, kLeastLength = 0.5, kHealthyLength = 1.0;
  const bool is_before = known.is_measured_within(0, dip.first);
  const bool is_behind = known.is_measured_within(dip.last + 1, vessel.last + 1);
  if (is_before == is_behind || lesion.evidence >= kLeastEvidence) return false;
  const std::vector<double>& s = known.path.abscissa;
  const std::ptrdiff_t step = is_before ? -1 : 1;
  const auto end = is_before ? std::ptrdiff_t(-1) : std::ptrdiff_t(vessel.last) + 1;
  double wide = 0.0, healthy = 0.0;  // lengths in healthy diameters
  for (auto at = std::ptrdiff_t(is_before ? dip.first : dip.last) + step;
       at != end && healthy < kHealthyLength; at += step) {
    const auto i = std::size_t(at);
    if (!known.is_measured(i)) continue;
    const double diameter = known.reference.diameter[i];
    const double length =
        0.5 * (s[std::min(i + 1, s.size() - 1)] - s[i > 0 ? i - 1 : i]) / diameter;
    if (known.reference.measured[i] > kWide * diameter) wide += length;
    if (known.reference.healthy[i] != 0) healthy += length;
  }
  return wide > kLeastLength;
}

/// How often the width swings to and fro within a reach [mm] of a place, by kSwing each time. Told
/// by cells of a quarter of a diameter: single points of a throat err by as much. Where little of
/// the healthy width is left, errors are a large share of the rest: a fifth of it is added.
int count_swings(const Known& known, const Vessel& vessel, double place, double reach) {
  constexpr double kSwing = 0.25, kAdded = 0.2;  // of ln(diameter / reference + added)
  int swings = 0, direction = 0;
  double low = 0.0, high = 0.0;  // since the last swing
  std::pair<int, int> last{-1, -1};
  for (std::size_t i = vessel.first; i <= vessel.last; ++i) {
    const std::pair<int, int> at{known.reference.branch[i], known.reference.cell[i]};
    if (at.second < 0 || at == last || std::abs(known.path.abscissa[i] - place) > reach) continue;
    const bool is_first = last.second < 0;
    last = at;
    const double diameter = std::exp(known.tree.field_branches[std::size_t(at.first)]
                                         .cells[std::size_t(at.second)]
                                         .log_diameter);
    const double width = std::log(diameter / known.reference.diameter[i] + kAdded);
    low = is_first ? width : std::min(low, width);
    high = is_first ? width : std::max(high, width);
    const int turned = direction <= 0 && width > low + kSwing    ? 1
                       : direction >= 0 && width < high - kSwing ? -1
                                                                 : 0;
    if (turned == 0) continue;
    direction = turned;
    low = high = width;
    ++swings;
  }
  return swings;
}

/// Whether a dip is one bead of many on a string: within eight healthy diameters of it the width
/// swings to and fro more often than it does in three stenoses one behind the other. So look the
/// thin veins of many a segmentation, and renal arteries with fibromuscular dysplasia, in which a
/// diameter stenosis is no measure either (Gornik et al., Vasc. Med. 24(2), 2019,
/// doi:10.1177/1358863X18821816).
bool is_a_bead(const Known& known, const Vessel& vessel, const Dip& dip) {
  constexpr double kReach = 8.0;
  constexpr int kSwingsOfThreeStenoses = 6;
  return count_swings(known, vessel, known.path.abscissa[dip.tightest],
                      kReach * known.reference.diameter[dip.tightest]) > kSwingsOfThreeStenoses;
}

}  // namespace

bool is_wider_than_beside(const Lesion& lesion) {
  constexpr double kMostStep = 1.5;
  const double beside = std::max(lesion.reference_proximal_mm, lesion.reference_distal_mm);
  return lesion.reference_proximal_mm > 0.0 && lesion.reference_distal_mm > 0.0 &&
         lesion.reference_tree_mm > kMostStep * beside;
}

Doubt find_doubt(const Known& known, const Vessel& vessel, const Dip& dip, const Lesion& lesion,
                 const LesionSurroundings& around) {
  if (is_wider_than_beside(lesion)) return Doubt::faint;
  if (lies_beside_no_tube(known, dip)) return Doubt::beside_no_tube;
  if (around.is_crowded &&
      (lesion.reference_diameter_mm > kWidestTreated || lies_beyond_the_heart(known, dip)))
    return Doubt::heart;
  const std::vector<double>& s = known.path.abscissa;
  const auto is_end = [&](std::size_t tip) {
    return around.is_scan || is_closed_at(tip, known, dip);
  };
  if (is_end(0) && lies_at(s.front(), dip.first, known, dip)) return Doubt::at_beginning;
  if (is_end(s.size() - 1) && lies_at(s.back(), dip.last, known, dip)) return Doubt::at_end;
  if (lies_beyond_aneurysm(known, vessel, dip, lesion)) return Doubt::beyond_aneurysm;
  if (is_a_bead(known, vessel, dip)) return Doubt::bead;
  return Doubt::none;
}

}  // namespace angio::centerline

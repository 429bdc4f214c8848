#include "centerline/detail/diffuse.hpp"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/statistics.hpp"

namespace angio::centerline {
namespace {

constexpr double kTip = 0.5;        ///< [diameters] of an end that tell nothing
constexpr double kEnd = 1.5;        ///< [diameters] of an end that tell its diameter
constexpr double kMostApart = 1.8;  ///< of the ends' diameters
constexpr double kShare = 0.4;      ///< of the vessel: about most of it

/// An end of a vessel.
struct End {
  double at = 0.0;        ///< abscissa of its middle [mm]
  double diameter = 0.0;  ///< [mm]
};

/// @param step  +1 from the first point on, -1 from the last one back
std::optional<End> end_of(const Known& known, const Vessel& vessel, int step) {
  const std::vector<double>& s = known.path.abscissa;
  const std::size_t from = step > 0 ? vessel.first : vessel.last;
  std::vector<double> diameters, places;
  for (std::size_t n = 0; n <= vessel.last - vessel.first; ++n) {
    const std::size_t i = step > 0 ? from + n : from - n;
    if (!known.is_measured(i)) continue;
    const double diameter = known.reference.measured[i], away = std::abs(s[i] - s[from]);
    if (away < kTip * diameter) continue;
    diameters.push_back(diameter);
    places.push_back(s[i]);
    if (away > (kTip + kEnd) * diameter) return End{median(places), median(diameters)};
  }
  return {};
}

}  // namespace

std::optional<Lesion> find_diffuse(const Known& known, const Vessel& vessel, double least_percent) {
  const std::optional<End> begin = end_of(known, vessel, 1), end = end_of(known, vessel, -1);
  if (!begin || !end || end->at <= begin->at) return {};
  const double taper = std::log(end->diameter / begin->diameter);
  if (std::abs(taper) > std::log(kMostApart)) return {};
  const std::vector<double>& s = known.path.abscissa;
  const auto line = [&](std::size_t i) {
    return begin->diameter * std::exp(taper * (s[i] - begin->at) / (end->at - begin->at));
  };
  const auto percent = [&](std::size_t i) {
    return 100.0 * (1.0 - known.reference.measured[i] / line(i));
  };
  Dip longest{0, 0, 0}, now{0, 0, 0};
  double length = -1.0;
  bool is_in_one = false;
  for (std::size_t i = vessel.first; i <= vessel.last; ++i) {
    if (!known.is_measured(i)) continue;
    if (percent(i) < least_percent) {
      is_in_one = false;
      continue;
    }
    if (!is_in_one) now = Dip{i, i, i};
    is_in_one = true;
    now.last = i;
    if (percent(i) > percent(now.tightest)) now.tightest = i;
    if (s[now.last] - s[now.first] < length) continue;
    length = s[now.last] - s[now.first];
    longest = now;
  }
  const std::size_t at = longest.tightest;
  if (length < kShare * (s[vessel.last] - s[vessel.first]) || known.percent(at) >= kShoulderPercent)
    return {};
  Lesion lesion;
  lesion.doubt = Doubt::diffuse;
  lesion.path_id = known.path.id;
  lesion.abscissa_mm = s[at];
  lesion.proximal_mm = s[longest.first];
  lesion.distal_mm = s[longest.last];
  lesion.length_mm = lesion.distal_mm - lesion.proximal_mm;
  lesion.mld_mm = known.reference.measured[at];
  lesion.mla_mm2 = known.path.section_area[at];
  lesion.reference_rule = "ends";
  lesion.reference_diameter_mm = line(at);
  lesion.diameter_stenosis_percent = percent(at);
  return lesion;
}

}  // namespace angio::centerline

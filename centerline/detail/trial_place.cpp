#include "centerline/detail/trial_place.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "centerline/treated.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

/// Distance [mm] from a point to the nearest branching on its path.
double distance_to_branching(const CenterlinePath& path, double s) {
  double nearest = path.abscissa.back();
  for (const CenterlineTract& tract : path.tracts) {
    if (!tract.blanking) continue;
    const double begin = path.abscissa[std::size_t(tract.first_point)];
    const double end = path.abscissa[std::size_t(tract.last_point)];
    nearest = std::min(nearest, std::max({begin - s, s - end, 0.0}));
  }
  return nearest;
}

/// Whether the narrowing at a point, if there is one, is but a bridge.
bool is_on_bridge(const Known& known, const Vessel& vessel, std::size_t i) {
  const double s = known.path.abscissa[i];
  if (known.percent(i) < kShoulderPercent)
    return turns_like_a_bridge(known.path, s, known.reference.diameter[i]);
  const Lesion lesion = describe_dip(known, vessel, grow_dip(known, vessel, i));
  return is_no_neck(lesion) || looks_like_a_bridge(known.path, lesion);
}

/// Whether the largest circle fills two thirds of the section: beside a sac, or where the line
/// crosses one, it does not.
bool is_tube(const CenterlinePath& path, std::size_t i) {
  constexpr double kLeastShare = 2.0 / 3.0;
  return std::pow(measured_radius(path)[i], 2.0) >=
         kLeastShare * std::pow(path.equivalent_radius[i], 2.0);
}

/// By how much the vessel turns along a balloon of two diameters [degrees].
double turn_along(const CenterlinePath& path, double s, double diameter) {
  const double cosine = dot(sample(path, s - diameter).tangent, sample(path, s + diameter).tangent);
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / units::kPi;
}

}  // namespace

ReferenceDiameter no_wider_than_around(const Known& known) {
  constexpr double kLongVessel = 15.0, kAsThin = 1.5;  // of its diameters
  const std::vector<double>&abscissa = known.path.abscissa, &measured = known.reference.measured;
  ReferenceDiameter own = known.reference;
  for (std::size_t i = 0; i < abscissa.size(); ++i) {
    if (!known.is_measured(i)) continue;
    const double reach = std::max(3.0 * known.reference.diameter[i], 5.0 * measured[i]);
    const auto first = std::lower_bound(abscissa.begin(), abscissa.end(), abscissa[i] - reach),
               last = std::upper_bound(abscissa.begin(), abscissa.end(), abscissa[i] + reach);
    std::vector<double> around;
    for (auto at = first; at != last; ++at)
      if (const double d = measured[std::size_t(at - abscissa.begin())]; d > 0.0)
        around.push_back(d);
    const double width = median(std::move(around));
    const auto is_as_thin = [&](std::size_t k) { return measured[k] <= kAsThin * width; };
    std::size_t begin = i, end = i;
    while (begin > 0 && is_as_thin(begin - 1)) --begin;
    while (end + 1 < abscissa.size() && is_as_thin(end + 1)) ++end;
    if (abscissa[end] - abscissa[begin] >= kLongVessel * width)
      own.diameter[i] = std::min(own.diameter[i], width);
  }
  return own;
}

Lesion tightest_place(const Known& known, double min_reference_mm) {
  const CenterlinePath& path = known.path;
  const Vessel whole{0, 0, path.points.size() - 1};
  const double length = path.abscissa.back();
  std::optional<std::size_t> best;
  double best_score = 0.0;
  std::size_t middle = 0;
  // Rather where a balloon is placed unasked; in the last resort, anywhere.
  const double trial = std::max(kLeastTreated, min_reference_mm);
  struct Asked {
    double diameters, least;
    bool tube;
  };
  for (const auto& [diameters, least, tube] : {Asked{1.0, trial, true},
                                               {0.0, trial, true},
                                               {1.0, min_reference_mm, true},
                                               {0.0, min_reference_mm, true},
                                               {1.0, trial, false},
                                               {0.0, trial, false},
                                               {1.0, min_reference_mm, false},
                                               {0.0, min_reference_mm, false},
                                               {-1.0, 0.0, false}}) {
    if (best) break;
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const double s = path.abscissa[i];
      if (s <= 0.5 * length) middle = i;
      const double d = known.reference.diameter[i];
      // A balloon of a few mm with its cones, or two diameters of the healthy vessel: a closed end
      // tapers to nothing within one.
      const double margin = std::min(std::max(2.0 * d, 5.0 + d), 0.4 * length);
      if (!known.is_measured(i) || s < margin || length - s < margin) continue;
      if (distance_to_branching(path, s) < diameters * d) continue;
      if (d < least || (tube && !is_tube(path, i)) ||
          (diameters >= 0.0 && is_on_bridge(known, whole, i)))
        continue;
      // Two points of %DS are no difference: then rather in the middle. In a bend a balloon kinks:
      // what turns by more than 45 degrees along it counts as wider by half a point a degree.
      const double bend = std::max(0.0, turn_along(path, s, d) - 45.0);
      const double score = known.percent(i) - 4.0 * std::abs(s / length - 0.5) - 0.5 * bend;
      if (best && score <= best_score) continue;
      best = i;
      best_score = score;
    }
  }
  const std::size_t at = best.value_or(middle);
  return describe_dip(known, whole, {at, at, at});
}

}  // namespace angio::centerline

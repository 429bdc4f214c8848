#include "centerline/detail/dip.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "centerline/detail/bridge_shape.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

/// A bridge is shorter than this many reference diameters; or has the shape of bridge_shape.hpp. A
/// stenosis in a bend is longer.
constexpr double kLeastLength = 0.5;

/// A stenosis narrows the section, too. Even a slit as wide as the healthy vessel, left by plaque
/// on two sides, has an area stenosis of more than 0.8 times its diameter stenosis; where the area
/// falls by less than half of it, the line runs off the middle or the section holds two vessels.
constexpr double kLeastAreaShare = 0.5;

/// The narrowest place of a dip, of those that are narrowed by a percentage where any is: a vessel
/// that tapers may be narrower, but less narrowed, behind its tightest place.
std::size_t narrowest_of(const Known& known, const Dip& dip, double least_percent) {
  const bool is_any = known.percent(dip.tightest) >= least_percent;
  std::size_t narrowest = dip.tightest;
  for (std::size_t k = dip.first; k <= dip.last; ++k)
    if (known.is_measured(k) && (!is_any || known.percent(k) >= least_percent) &&
        known.reference.measured[k] < known.reference.measured[narrowest])
      narrowest = k;
  return narrowest;
}

/// Abscissa between points a (narrow) and b (not) where the stenosis is the shoulder's.
double shoulder(const Known& known, std::size_t a, std::size_t b) {
  const double pa = known.percent(a), pb = known.percent(b);
  const auto& s = known.path.abscissa;
  if (!known.is_measured(b) || pa - pb <= 0.0) return s[a];
  const double t = std::clamp((pa - kShoulderPercent) / (pa - pb), 0.0, 1.0);
  return s[a] + t * (s[b] - s[a]);
}

std::size_t lowest_of(const Known& known, const std::vector<double>& values, const Dip& dip) {
  std::size_t lowest = dip.tightest;
  for (std::size_t k = dip.first; k <= dip.last; ++k)
    if (known.is_measured(k) && values[k] < values[lowest]) lowest = k;
  return lowest;
}

/// A positive measure at the place of a dip where it is lowest: the least of the parabola through
/// the values within a fifth of the vessel's diameter around it. A least value of single points
/// would be that of their worst error.
double least_at(const Known& known, const std::vector<double>& values, const Dip& dip,
                std::size_t lowest) {
  constexpr double kReach = 0.2, kOwnReach = 0.5, kMostAbove = 1.25, kLeastBelow = 0.9;
  const auto& s = known.path.abscissa;
  const double reach = std::min(kReach * known.reference.diameter[lowest],
                                std::max(kOwnReach * known.reference.measured[lowest], 1e-9));
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sums = Eigen::Vector3d::Zero();
  int count = 0;
  for (std::size_t k = dip.first; k <= dip.last; ++k) {
    const double x = (s[k] - s[lowest]) / reach;
    if (std::abs(x) > 1.0 || !known.is_measured(k)) continue;
    const Eigen::Vector3d terms(1.0, x, x * x);
    squares += terms * terms.transpose();
    sums += values[k] * terms;
    ++count;
  }
  if (count < 4) return values[lowest];
  const Eigen::Vector3d fit = squares.ldlt().solve(sums);
  const double at = fit[2] > 0.0 ? std::clamp(-0.5 * fit[1] / fit[2], -1.0, 1.0) : 0.0;
  return std::clamp(fit[0] + at * (fit[1] + at * fit[2]), kLeastBelow * values[lowest],
                    kMostAbove * values[lowest]);
}

/// The points of a vessel within a reach [mm] before (-1) or behind (+1) an edge that keep(point)
/// is true for.
template <class Keep>
std::vector<std::size_t> points_beside(const Known& known, const Vessel& vessel, std::size_t edge,
                                       int direction, double reach, const Keep& keep) {
  std::vector<std::size_t> points;
  const auto& s = known.path.abscissa;
  for (auto i = std::ptrdiff_t(edge) + direction;
       i >= std::ptrdiff_t(vessel.first) && i <= std::ptrdiff_t(vessel.last); i += direction) {
    const auto at = std::size_t(i);
    if (std::abs(s[at] - s[edge]) > reach) break;
    if (keep(at)) points.push_back(at);
  }
  return points;
}

/// Those of them that are healthy.
std::vector<std::size_t> healthy_beside(const Known& known, const Vessel& vessel, std::size_t edge,
                                        int direction, double reach) {
  return points_beside(known, vessel, edge, direction, reach,
                       [&](std::size_t at) { return known.reference.healthy[at] != 0; });
}

/// The median diameter of points; 0 of less than two.
double median_diameter(const Known& known, const std::vector<std::size_t>& points) {
  if (points.size() < 2) return 0.0;
  std::vector<double> diameters;
  for (const std::size_t i : points) diameters.push_back(known.reference.measured[i]);
  return median(std::move(diameters));
}

/// The length that points stand for [mm].
double length_of(const Known& known, const std::vector<std::size_t>& points) {
  const auto& s = known.path.abscissa;
  double length = 0.0;
  for (const std::size_t i : points)
    length += 0.5 * (s[std::min(i + 1, s.size() - 1)] - s[i > 0 ? i - 1 : i]);
  return length;
}

/// The straight line through the healthy diameters of a dip's own branch within five diameters of
/// its edges, read at a place; 0 unless a diameter is healthy on either side.
double interpolate(const Known& known, const Vessel& vessel, const Dip& dip, std::size_t place) {
  constexpr double kReach = 5.0, kShoulder = 5.0;  // the latter in percent
  const double diameter = known.reference.diameter[place];
  const auto& s = known.path.abscissa;
  const int branch = known.reference.branch[place];
  double n = 0.0, sum_t = 0.0, sum_d = 0.0, sum_tt = 0.0, sum_td = 0.0;
  for (const int direction : {-1, 1}) {
    auto points = healthy_beside(known, vessel, direction < 0 ? dip.first : dip.last, direction,
                                 kReach * diameter);
    // The lesion's shoulders would draw the line down.
    std::erase_if(points, [&](std::size_t i) {
      return known.reference.branch[i] != branch || std::abs(known.percent(i)) > kShoulder;
    });
    if (length_of(known, points) < diameter) return 0.0;
    for (const std::size_t i : points) {
      const double t = s[i] - s[place], d = known.reference.measured[i];
      n += 1.0;
      sum_t += t;
      sum_d += d;
      sum_tt += t * t;
      sum_td += t * d;
    }
  }
  return (sum_d * sum_tt - sum_td * sum_t) / (n * sum_tt - sum_t * sum_t);
}

/// The median diameter between half a diameter and two and a half beyond an edge, of what is no
/// lesion there; 0 where that is less than a diameter of vessel.
double width_beyond(const Known& known, const Vessel& vessel, std::size_t edge, int direction,
                    double diameter) {
  constexpr double kFrom = 0.5, kTo = 2.5, kLeastSeen = 1.0;
  const auto& s = known.path.abscissa;
  const std::vector<std::size_t> points =
      points_beside(known, vessel, edge, direction, kTo * diameter, [&](std::size_t at) {
        return std::abs(s[at] - s[edge]) >= kFrom * diameter && known.is_measured(at) &&
               known.percent(at) < kShoulderPercent;
      });
  return length_of(known, points) < kLeastSeen * diameter ? 0.0 : median_diameter(known, points);
}

/// The wider of both sides of a lesion, where the tree's reference is over a tenth wider than
/// either; else 0. Disease does not draw them down: what is narrowed by a fifth is the lesion's.
double reference_of_sides(const Known& known, const Vessel& vessel, const Dip& dip,
                          double by_tree) {
  constexpr double kMostAbove = 1.1;
  const double before = width_beyond(known, vessel, dip.first, -1, by_tree),
               behind = width_beyond(known, vessel, dip.last, +1, by_tree);
  const double wider = std::max(before, behind);
  return std::min(before, behind) > 0.0 && by_tree > kMostAbove * wider ? wider : 0.0;
}

/// The mean of the 0.9 quantiles of the diameters of a dip's own branch within three diameters
/// before and behind its edges; 0 unless both are seen over a diameter.
double widest_beside(const Known& known, const Vessel& vessel, const Dip& dip, double diameter) {
  constexpr double kReach = 3.0, kLeastSeen = 1.0, kShare = 0.9;
  const int branch = known.reference.branch[dip.tightest];
  double sum = 0.0;
  for (const int direction : {-1, 1}) {
    const std::vector<std::size_t> points =
        points_beside(known, vessel, direction < 0 ? dip.first : dip.last, direction,
                      kReach * diameter, [&](std::size_t at) {
                        return known.reference.branch[at] == branch && known.is_measured(at);
                      });
    if (length_of(known, points) < kLeastSeen * diameter) return 0.0;
    std::vector<double> diameters;
    for (const std::size_t at : points) diameters.push_back(known.reference.measured[at]);
    sum += quantile(diameters, kShare);
  }
  return 0.5 * sum;
}

/// How wide a dip's own branch is right before and behind its tightest place; 0 unless the branch
/// is seen over one and a half healthy diameters to both sides: nearer to a fork the vessel before
/// the throat is another branch.
double beside_throat(const Known& known, const Dip& dip) {
  constexpr double kLeastSeen = 1.5;
  const int cell = known.reference.cell[dip.tightest];
  if (cell < 0) return 0.0;
  const auto& cells =
      known.tree.field_branches[std::size_t(known.reference.branch[dip.tightest])].cells;
  const FieldCell& tightest = cells[std::size_t(cell)];
  const double seen = std::min(tightest.abscissa_mm - cells.front().abscissa_mm,
                               cells.back().abscissa_mm - tightest.abscissa_mm);
  return seen < kLeastSeen * known.reference.diameter[dip.tightest] ? 0.0
                                                                    : std::exp(tightest.log_sides);
}

void set_references(const Known& known, const Vessel& vessel, const Dip& dip, std::size_t place,
                    Lesion& lesion) {
  constexpr double kReach = 3.0;
  const auto beside = [&](std::size_t edge, int direction) {
    return median_diameter(known, healthy_beside(known, vessel, edge, direction,
                                                 kReach * known.reference.diameter[edge]));
  };
  lesion.reference_rule = "tree";
  lesion.reference_tree_mm = known.reference.diameter[place];
  lesion.reference_diameter_mm = lesion.reference_tree_mm;
  if (const double sides = reference_of_sides(known, vessel, dip, lesion.reference_tree_mm);
      sides > 0.0) {
    lesion.reference_rule = "sides";
    lesion.reference_diameter_mm = sides;
  }
  lesion.reference_interpolated_mm = interpolate(known, vessel, dip, place);
  lesion.reference_proximal_mm = beside(dip.first, -1);
  lesion.reference_distal_mm = beside(dip.last, +1);
  lesion.widest_beside_mm = widest_beside(known, vessel, dip, lesion.reference_diameter_mm);
  lesion.beside_throat_mm = beside_throat(known, dip);
  const int sides = int(lesion.reference_proximal_mm > 0.0) + int(lesion.reference_distal_mm > 0.0);
  if (sides > 0)
    lesion.reference_average_mm =
        (lesion.reference_proximal_mm + lesion.reference_distal_mm) / sides;
}

/// The angles [rad] by which a line turns before and behind s: between its chords over [-3/2,
/// -1/2], [-1/2, 1/2] and [1/2, 3/2] diameters, as far as the line reaches. Chords that long do not
/// see how a line wanders in a flat lumen.
std::array<double, 2> turning(const CenterlinePath& path, double s, double diameter) {
  std::array<double, 2> angles{};
  const auto chord = [&](double middle) {
    return normalized(sample(path, s + (middle + 0.5) * diameter).point -
                      sample(path, s + (middle - 0.5) * diameter).point);
  };
  for (const int side : {0, 1}) {
    const double end = s + (side == 0 ? -1.5 : 1.5) * diameter;
    if (end < 0.0 || end > path.abscissa.back()) continue;
    const double cosine = dot(chord(0.0), chord(side == 0 ? -1.0 : 1.0));
    angles[std::size_t(side)] = std::acos(std::clamp(cosine, -1.0, 1.0));
  }
  return angles;
}

/// Whether a vessel passes a dip by, within a bridge's length of it.
bool is_passed_by(const Known& known, const Vessel& vessel, const Dip& dip) {
  constexpr double kAsWide = 0.6;
  const std::vector<double>& s = known.path.abscissa;
  const double place = s[dip.tightest];
  const double reach = kBridgeFromAxisToAxis * known.reference.diameter[dip.tightest];
  const TreeReference& tree = known.tree;
  for (std::size_t i = vessel.first > 0 ? vessel.first - 1 : 0; i < vessel.last; ++i) {
    const int before = known.reference.branch[i], behind = known.reference.branch[i + 1];
    if (before == behind || std::abs(s[i] - place) > reach) continue;
    const auto& cells = tree.field_branches[std::size_t(before)].cells;
    const double passing = s[i] < place ? tree.field.best(std::size_t(before), cells.size() - 1)
                                        : tree.field.best(std::size_t(behind), 0);
    for (const int aside : tree.branches[std::size_t(before)].daughters)
      if (aside != behind && tree.field.best(std::size_t(aside), 0) > passing + std::log(kAsWide))
        return true;
  }
  return false;
}

}  // namespace

Dip grow_dip(const Known& known, const Vessel& vessel, std::size_t at) {
  Dip dip{at, at, at};
  if (known.percent(at) < kShoulderPercent) return dip;
  for (std::size_t i = at; i > vessel.first; --i) {
    if (!known.is_measured(i - 1)) continue;
    if (known.percent(i - 1) < kShoulderPercent) break;
    dip.first = i - 1;
  }
  for (std::size_t i = at; i < vessel.last; ++i) {
    if (!known.is_measured(i + 1)) continue;
    if (known.percent(i + 1) < kShoulderPercent) break;
    dip.last = i + 1;
  }
  for (std::size_t i = dip.first; i <= dip.last; ++i)
    if (known.percent(i) > known.percent(dip.tightest)) dip.tightest = i;
  return dip;
}

Lesion describe_dip(const Known& known, const Vessel& vessel, const Dip& dip,
                    double least_percent) {
  const CenterlinePath& path = known.path;
  const std::size_t place = narrowest_of(known, dip, least_percent);
  Lesion lesion;
  lesion.path_id = path.id;
  lesion.abscissa_mm = path.abscissa[place];
  if (known.is_measured(place)) {
    lesion.mld_mm = least_at(known, known.reference.measured, dip, place);
    lesion.mla_mm2 =
        least_at(known, path.section_area, dip, lowest_of(known, path.section_area, dip));
  } else {  // a place that the user chose in a branching
    lesion.mld_mm = 2.0 * measured_radius(path)[place];
    lesion.mla_mm2 = path.section_area[place];
  }
  set_references(known, vessel, dip, place, lesion);
  const double diameter = lesion.reference_diameter_mm;
  lesion.diameter_stenosis_percent = std::max(0.0, 100.0 * (1.0 - lesion.mld_mm / diameter));
  lesion.area_stenosis_percent =
      std::max(0.0, 100.0 * (1.0 - lesion.mla_mm2 / (0.25 * units::kPi * diameter * diameter)));
  lesion.proximal_mm = lesion.distal_mm = lesion.abscissa_mm;
  if (known.percent(dip.tightest) >= kShoulderPercent) {
    lesion.proximal_mm = dip.first > vessel.first ? shoulder(known, dip.first, dip.first - 1)
                                                  : path.abscissa[vessel.first];
    lesion.distal_mm = dip.last < vessel.last ? shoulder(known, dip.last, dip.last + 1)
                                              : path.abscissa[vessel.last];
    lesion.length_mm = lesion.distal_mm - lesion.proximal_mm;
  }
  return lesion;
}

bool turns_like_a_bridge(const CenterlinePath& path, double s, double diameter) {
  const auto [before, behind] = turning(path, s, diameter);
  return before + behind > kBridgeTurning && std::min(before, behind) > kBridgeLeastTurn;
}

bool is_no_neck(const Lesion& lesion) {
  const double healthy = lesion.reference_tree_mm;
  const double diameter = 1.0 - lesion.mld_mm / healthy;
  const double area = 1.0 - lesion.mla_mm2 / (0.25 * units::kPi * healthy * healthy);
  return area < kLeastAreaShare * diameter;
}

bool looks_like_a_bridge(const CenterlinePath& path, const Lesion& lesion) {
  return lesion.length_mm < kLeastLength * lesion.reference_diameter_mm ||
         (lesion.length_mm < kBridgeFromAxisToAxis * lesion.reference_diameter_mm &&
          turns_like_a_bridge(path, lesion.abscissa_mm, lesion.reference_diameter_mm));
}

bool may_be_a_bridge(const Known& known, const Vessel& vessel, const Dip& dip,
                     const Lesion& lesion) {
  return looks_like_a_bridge(known.path, lesion) && is_passed_by(known, vessel, dip);
}

}  // namespace angio::centerline

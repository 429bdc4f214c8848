#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "centerline/centerline.hpp"
#include "centerline/detail/reference.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace angio::centerline {

void LesionOptions::validate() const {
  if (!(min_stenosis_percent >= 10.0 && min_stenosis_percent <= 90.0))
    throw OptionError("lesion.min_stenosis_percent is " + std::to_string(min_stenosis_percent) +
                      ". Give 10 to 90 %");
  if (!(min_reference_mm >= 0.0 && min_reference_mm <= 30.0))
    throw OptionError("lesion.min_reference_mm is " + std::to_string(min_reference_mm) +
                      ". Give 0 to 30 mm");
  if (centerline < -1)
    throw OptionError("lesion.centerline is " + std::to_string(centerline) +
                      ". Give the id of a path, or -1 for all of them");
  if (!std::isfinite(abscissa_mm)) throw OptionError("lesion.abscissa_mm is not a number");
}

namespace {

/// A lesion is as long as the stretch around its tightest place with at least this stenosis.
constexpr double kShoulderPercent = 20.0;

/// Two vessels that touch are bridged by a few voxels, and a line that crosses such a bridge is
/// narrow there. Unlike a stenosis, the bridge is shorter than this many reference diameters, or
/// the line turns by more than this (80 degrees) around it.
constexpr double kLeastLength = 0.5;
constexpr double kMostTurning = 80.0 / 180.0 * units::kPi;

/// A stenosis narrows the section, too. Even a slit as wide as the healthy vessel, left by plaque
/// on two sides, has an area stenosis of more than 0.8 times its diameter stenosis; where the area
/// falls by less than half of it, the line runs off the middle or the section holds two vessels.
constexpr double kLeastAreaShare = 0.5;

/// Relative to the reference: a vessel that does not come back to this on both sides of a dip is
/// tapering or ending, not stenosed.
constexpr double kRecovered = 0.80;

double stenosis_percent(const CenterlinePath& path, const ReferenceDiameter& reference,
                        std::size_t i) {
  if (reference.segment[i] < 0) return 0.0;
  return 100.0 * (1.0 - 2.0 * path.inscribed_radius[i] / reference.diameter[i]);
}

/// Points [first, last] of a segment around a place where the stenosis is at least the shoulder's.
struct Dip {
  std::size_t first, last, tightest;
};

Dip grow_dip(const CenterlinePath& path, const ReferenceDiameter& reference, std::size_t at) {
  const auto narrow = [&](std::size_t i) {
    return stenosis_percent(path, reference, i) >= kShoulderPercent;
  };
  Dip dip{at, at, at};
  if (!narrow(at)) return dip;
  while (dip.first > 0 && narrow(dip.first - 1)) --dip.first;
  while (dip.last + 1 < path.points.size() && narrow(dip.last + 1)) ++dip.last;
  for (std::size_t i = dip.first; i <= dip.last; ++i)
    if (stenosis_percent(path, reference, i) > stenosis_percent(path, reference, dip.tightest))
      dip.tightest = i;
  return dip;
}

/// Abscissa between points a (narrow) and b (not) where the stenosis is the shoulder's.
double shoulder(const CenterlinePath& path, const ReferenceDiameter& reference, std::size_t a,
                std::size_t b) {
  const double pa = stenosis_percent(path, reference, a);
  const double pb = stenosis_percent(path, reference, b);
  if (reference.segment[b] < 0 || pa - pb <= 0.0) return path.abscissa[a];
  const double t = std::clamp((pa - kShoulderPercent) / (pa - pb), 0.0, 1.0);
  return path.abscissa[a] + t * (path.abscissa[b] - path.abscissa[a]);
}

/// The least value of a measure over a dip: of the parabola through its lowest point and the points
/// beside it, because the throat lies between points.
double least_of(const CenterlinePath& path, const std::vector<double>& values, const Dip& dip) {
  const auto begin = values.begin() + std::ptrdiff_t(dip.first);
  const auto lowest = std::min_element(begin, values.begin() + std::ptrdiff_t(dip.last) + 1);
  const auto i = std::size_t(lowest - values.begin());
  if (i == dip.first || i == dip.last) return *lowest;
  const double a = path.abscissa[i] - path.abscissa[i - 1];
  const double b = path.abscissa[i + 1] - path.abscissa[i];
  const double before = (values[i - 1] - values[i]) / a, after = (values[i + 1] - values[i]) / b;
  const double bend = (before + after) / (a + b);
  const double slope = (after * a - before * b) / (a + b);
  return bend > 0.0 ? *lowest - 0.25 * slope * slope / bend : *lowest;
}

/// The healthy diameter just outside an edge of a lesion: the median within three diameters; 0 when
/// no healthy vessel is there before the next branching.
double healthy_beside(const CenterlinePath& path, const ReferenceDiameter& reference,
                      std::size_t edge, int direction) {
  constexpr double kReach = 3.0;
  std::vector<double> diameters;
  const double most = kReach * reference.diameter[edge];
  const auto count = std::ptrdiff_t(path.points.size());
  for (auto i = std::ptrdiff_t(edge) + direction; i >= 0 && i < count; i += direction) {
    const auto at = std::size_t(i);
    if (std::abs(path.abscissa[at] - path.abscissa[edge]) > most) break;
    if (reference.healthy[at] != 0) diameters.push_back(2.0 * path.inscribed_radius[at]);
  }
  if (diameters.size() < 2) return 0.0;
  const auto middle = diameters.begin() + std::ptrdiff_t(diameters.size() / 2);
  std::nth_element(diameters.begin(), middle, diameters.end());
  return *middle;
}

void set_references(const CenterlinePath& path, const ReferenceDiameter& reference, const Dip& dip,
                    Lesion& lesion) {
  const std::size_t at = dip.tightest;
  lesion.reference_diameter_mm = lesion.mld_mm;
  lesion.reference_rule = "average";
  if (reference.segment[at] < 0) return;
  const double proximal = healthy_beside(path, reference, dip.first, -1);
  const double distal = healthy_beside(path, reference, dip.last, +1);
  const int sides = int(proximal > 0.0) + int(distal > 0.0);
  if (sides > 0) lesion.reference_average_mm = (proximal + distal) / sides;
  lesion.reference_diameter_mm = reference.diameter[at];
  if (reference.interpolated[at] == 0) return;
  lesion.reference_rule = "interpolated";
  lesion.reference_interpolated_mm = reference.diameter[at];
}

Lesion describe(const CenterlinePath& path, const ReferenceDiameter& reference, const Dip& dip) {
  Lesion lesion;
  lesion.path_id = path.id;
  lesion.abscissa_mm = path.abscissa[dip.tightest];
  lesion.mld_mm = 2.0 * least_of(path, path.inscribed_radius, dip);
  lesion.mla_mm2 = least_of(path, path.section_area, dip);
  set_references(path, reference, dip, lesion);
  const double diameter = lesion.reference_diameter_mm;
  lesion.diameter_stenosis_percent = std::max(0.0, 100.0 * (1.0 - lesion.mld_mm / diameter));
  lesion.area_stenosis_percent =
      std::max(0.0, 100.0 * (1.0 - lesion.mla_mm2 / (0.25 * units::kPi * diameter * diameter)));
  lesion.proximal_mm = lesion.distal_mm = lesion.abscissa_mm;
  if (stenosis_percent(path, reference, dip.tightest) >= kShoulderPercent) {
    lesion.proximal_mm =
        dip.first > 0 ? shoulder(path, reference, dip.first, dip.first - 1) : path.abscissa.front();
    lesion.distal_mm = dip.last + 1 < path.points.size()
                           ? shoulder(path, reference, dip.last, dip.last + 1)
                           : path.abscissa.back();
    lesion.length_mm = lesion.distal_mm - lesion.proximal_mm;
  }
  return lesion;
}

/// True when the vessel is wide again somewhere between `from` and the border of what was measured.
bool recovers(const CenterlinePath& path, const ReferenceDiameter& reference, std::size_t from,
              int direction) {
  const double wanted = kRecovered * reference.diameter[from];
  const double reach = 6.0 * reference.diameter[from];
  for (std::size_t i = from; std::abs(path.abscissa[i] - path.abscissa[from]) <= reach;
       i = direction > 0 ? i + 1 : i - 1) {
    if (reference.segment[i] >= 0 && 2.0 * path.inscribed_radius[i] >= wanted) return true;
    if ((direction < 0 && i == 0) || (direction > 0 && i + 1 == path.points.size())) break;
  }
  return false;
}

/// The angle [rad] by which a line turns around s: between its chords over [-3/2, -1/2], [-1/2,
/// 1/2] and [1/2, 3/2] diameters. Chords that long do not see how a line wanders in a flat lumen.
double turning(const CenterlinePath& path, double s, double diameter) {
  double sum = 0.0;
  Vec3 before;
  for (const double first : {-1.5, -0.5, 0.5}) {
    const Vec3 chord = normalized(sample(path, s + (first + 1.0) * diameter).point -
                                  sample(path, s + first * diameter).point);
    sum += first > -1.0 ? std::acos(std::clamp(dot(before, chord), -1.0, 1.0)) : 0.0;
    before = chord;
  }
  return sum;
}

bool is_bridge(const CenterlinePath& path, const Lesion& lesion) {
  return lesion.length_mm < kLeastLength * lesion.reference_diameter_mm ||
         lesion.area_stenosis_percent < kLeastAreaShare * lesion.diameter_stenosis_percent ||
         turning(path, lesion.abscissa_mm, lesion.reference_diameter_mm) > kMostTurning;
}

struct Found {
  Lesion lesion;
  Vec3 point;
};

void find_on_path(const CenterlinePath& path, const LesionOptions& options,
                  std::vector<Found>& found) {
  const ReferenceDiameter reference = find_reference(path);
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    if (stenosis_percent(path, reference, i) < kShoulderPercent) continue;
    const Dip dip = grow_dip(path, reference, i);
    i = dip.last;
    if (stenosis_percent(path, reference, dip.tightest) < options.min_stenosis_percent) continue;
    if (reference.diameter[dip.tightest] < options.min_reference_mm) continue;
    if (!recovers(path, reference, dip.tightest, -1) ||
        !recovers(path, reference, dip.tightest, +1))
      continue;
    const Found next{describe(path, reference, dip), path.points[dip.tightest]};
    if (is_bridge(path, next.lesion)) continue;
    // Lines that share a stretch share its lesions: the longest path has been first.
    const bool known = std::any_of(found.begin(), found.end(), [&](const Found& other) {
      return distance(other.point, next.point) < 0.5 * next.lesion.reference_diameter_mm;
    });
    if (!known) found.push_back(next);
  }
}

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
bool is_on_bridge(const CenterlinePath& path, const ReferenceDiameter& reference, std::size_t i) {
  const double s = path.abscissa[i];
  if (stenosis_percent(path, reference, i) < kShoulderPercent)
    return turning(path, s, reference.diameter[i]) > kMostTurning;
  return is_bridge(path, describe(path, reference, grow_dip(path, reference, i)));
}

/// The tightest place, relative to the reference, that leaves room for a balloon on both sides, in
/// a vessel that balloons are made for, and a diameter away from branchings, if there is one.
Lesion tightest_place(const CenterlinePath& path, double min_reference_mm) {
  const ReferenceDiameter reference = find_reference(path);
  const double length = path.abscissa.back();
  std::optional<std::size_t> best;
  double best_score = 0.0;
  std::size_t middle = 0;
  for (const double diameters : {1.0, 0.0, -1.0}) {  // in the last resort, anywhere
    if (best) break;
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const double s = path.abscissa[i];
      if (s <= 0.5 * length) middle = i;
      const double d = 2.0 * path.inscribed_radius[i];
      // A balloon of a few mm with its cones, or two diameters.
      const double margin = std::min(std::max(2.0 * d, 5.0 + d), 0.4 * length);
      if (reference.segment[i] < 0 || s < margin || length - s < margin) continue;
      if (distance_to_branching(path, s) < diameters * d) continue;
      if (diameters >= 0.0 &&
          (reference.diameter[i] < min_reference_mm || is_on_bridge(path, reference, i)))
        continue;
      // Two points of %DS are no difference: then rather in the middle.
      const double score = stenosis_percent(path, reference, i) - 4.0 * std::abs(s / length - 0.5);
      if (best && score <= best_score) continue;
      best = i;
      best_score = score;
    }
  }
  const std::size_t at = best.value_or(middle);
  return describe(path, reference, {at, at, at});
}

const CenterlinePath& path_with_id(const CenterlineTree& tree, int id) {
  for (const CenterlinePath& path : tree.paths)
    if (path.id == id) return path;
  throw OptionError("lesion.centerline is " + std::to_string(id) + ", but there are " +
                    std::to_string(tree.paths.size()) + " paths, numbered from 0");
}

Lesion lesion_at(const CenterlinePath& path, const LesionOptions& options) {
  if (options.abscissa_mm > path.abscissa.back())
    throw OptionError("lesion.abscissa_mm is " + std::to_string(options.abscissa_mm) +
                      ", but path " + std::to_string(path.id) + " is " +
                      std::to_string(path.abscissa.back()) + " mm long");
  const ReferenceDiameter reference = find_reference(path);
  const auto above =
      std::lower_bound(path.abscissa.begin(), path.abscissa.end(), options.abscissa_mm);
  const auto at = std::size_t(above - path.abscissa.begin());
  Lesion lesion = describe(path, reference, grow_dip(path, reference, at));
  lesion.abscissa_mm = options.abscissa_mm;
  lesion.is_stenosis = lesion.diameter_stenosis_percent >= options.min_stenosis_percent;
  return lesion;
}

}  // namespace

std::vector<Lesion> find_lesions(const CenterlineTree& tree, const LesionOptions& options) {
  options.validate();
  if (tree.paths.empty())
    throw InputError("the tree has no paths, so no lesion can be on them. Run centerline first");
  if (options.abscissa_mm >= 0.0)
    return {lesion_at(path_with_id(tree, std::max(options.centerline, 0)), options)};
  std::vector<Found> found;
  if (options.centerline >= 0) {
    find_on_path(path_with_id(tree, options.centerline), options, found);
  } else {
    for (const CenterlinePath& path : tree.paths) find_on_path(path, options, found);
  }
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
    return a.lesion.diameter_stenosis_percent > b.lesion.diameter_stenosis_percent;
  });
  std::vector<Lesion> lesions;
  for (Found& entry : found) {
    entry.lesion.is_stenosis = true;
    lesions.push_back(entry.lesion);
  }
  if (lesions.empty())
    lesions.push_back(tightest_place(
        options.centerline >= 0 ? path_with_id(tree, options.centerline) : tree.paths.front(),
        options.min_reference_mm));
  return lesions;
}

}  // namespace angio::centerline

#include "meshing/detail/healthy_vessel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "meshing/detail/nearest_line.hpp"

namespace angio::meshing::detail {
namespace {

constexpr double kBlendShare = 0.1;     // of the radius: the width in which tubes blend
constexpr double kKeptDiameters = 1.0;  // past a stretch's edges its reference holds
constexpr double kFadeDiameters = 2.0;  // and fades out
constexpr double kNearRadii = 6.0;      // from the box: lines further away are left out
constexpr double kExtension = 4.0;      // radii by which a line goes on straight past its end
constexpr double kTangentReach = 0.5;   // radii over which a line's direction is taken

/// 1 within a stretch and a diameter of it, then falling smoothly to 0.
double weight_of(const NarrowStretch& stretch, double abscissa) {
  const double outside =
      std::max({0.0, stretch.proximal_mm - abscissa, abscissa - stretch.distal_mm});
  const double past = outside / stretch.reference_diameter_mm - kKeptDiameters;
  const double t = std::clamp(past / kFadeDiameters, 0.0, 1.0);
  return 1.0 - t * t * (3.0 - 2.0 * t);
}

/// Direction over a radius: it does not follow every kink of the line.
Vec3 direction_at(const CenterlinePath& path, double abscissa, double radius) {
  const double reach = std::max(kTangentReach * radius, 1e-3);
  return normalized(sample(path, abscissa + reach).point - sample(path, abscissa - reach).point);
}

/// The line's course past a lesion: a cubic from a diameter before it to a diameter behind it.
///
/// A lesion on one side pushes the line aside, at most by as much as the lumen is narrower.
void straighten(const CenterlinePath& path, const NarrowStretch& stretch, HealthyPath& healthy) {
  const double margin = kKeptDiameters * stretch.reference_diameter_mm;
  const double first = std::max(stretch.proximal_mm - margin, path.abscissa.front());
  const double last = std::min(stretch.distal_mm + margin, path.abscissa.back());
  const double length = last - first;
  if (length <= 0.0) return;
  const double radius = 0.5 * stretch.reference_diameter_mm;
  const Vec3 a = sample(path, first).point, b = sample(path, last).point;
  const Vec3 slope_a = length * direction_at(path, first, radius),
             slope_b = length * direction_at(path, last, radius);
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const double t = (path.abscissa[i] - first) / length;
    if (t <= 0.0 || t >= 1.0) continue;
    const double u = 1.0 - t;
    const Vec3 cubic = (u * u * (1.0 + 2.0 * t)) * a + (t * t * (1.0 + 2.0 * u)) * b +
                       (u * u * t) * slope_a - (t * t * u) * slope_b;
    Vec3 shift = cubic - path.points[i];
    const double room = std::max(0.0, radius - path.inscribed_radius[i]);
    if (norm(shift) > room) shift *= room / norm(shift);
    healthy.points[i] = path.points[i] + shift;
  }
}

bool near_box(const Vec3& p, const Box& box, double margin) {
  for (int axis = 0; axis < 3; ++axis)
    if (p[axis] < box.low[axis] - margin || p[axis] > box.high[axis] + margin) return false;
  return true;
}

/// Every path without its lesions; where paths run together, with those of all of them.
std::vector<HealthyPath> heal_tree(const CenterlineTree& tree,
                                   const std::vector<NarrowStretch>& stretches) {
  std::vector<HealthyPath> healed;
  for (const CenterlinePath& path : tree.paths) healed.push_back(heal_path(path, stretches));
  for (std::size_t p = 1; p < tree.paths.size(); ++p)
    for (std::size_t q = 0; q < p; ++q) {
      const int shared = shared_point_count(tree.paths[p], tree.paths[q]);
      for (std::size_t i = 0; i < std::size_t(shared); ++i)
        if (healed[p].narrowed[i] > healed[q].narrowed[i]) {
          healed[q].radius[i] = healed[p].radius[i];
          healed[q].points[i] = healed[p].points[i];
          healed[q].narrowed[i] = healed[p].narrowed[i];
        }
    }
  return healed;
}

/// A path from a point on (and the one before it, so that it hangs together with the path that it
/// leaves); free ends go on straight.
HealthyLine line_of(const CenterlinePath& path, const HealthyPath& healed, std::size_t first) {
  HealthyLine line;
  const auto add = [&](std::size_t i, double ahead) {
    const Vec3 along = direction_at(path, path.abscissa[i], path.inscribed_radius[i]);
    line.points.push_back(healed.points[i] + (ahead * healed.radius[i]) * along);
    line.radius.push_back(healed.radius[i]);
    line.narrowed.push_back(healed.narrowed[i]);
    line.tangents.push_back(along);
  };
  if (path.points.empty() || first >= path.points.size()) return line;
  if (first == 0) add(0, -kExtension);
  for (std::size_t i = first > 0 ? first - 1 : 0; i < path.points.size(); ++i) add(i, 0.0);
  add(path.points.size() - 1, kExtension);
  return line;
}

}  // namespace

HealthyPath heal_path(const CenterlinePath& path, const std::vector<NarrowStretch>& stretches) {
  HealthyPath healthy{path.points, path.inscribed_radius,
                      std::vector<double>(path.points.size(), 0.0)};
  for (const NarrowStretch& stretch : stretches) {
    if (stretch.path_id != path.id) continue;
    const double reference = 0.5 * stretch.reference_diameter_mm;
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const double weight = weight_of(stretch, path.abscissa[i]);
      const double lack = std::max(0.0, reference - path.inscribed_radius[i]);
      healthy.radius[i] = std::max(healthy.radius[i], path.inscribed_radius[i] + weight * lack);
      healthy.narrowed[i] = std::max(healthy.narrowed[i], weight);
    }
    straighten(path, stretch, healthy);
  }
  return healthy;
}

HealthyVessel::HealthyVessel(const CenterlineTree& tree,
                             const std::vector<NarrowStretch>& stretches, const Box& box) {
  const std::vector<HealthyPath> healed = heal_tree(tree, stretches);
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    // A path begins where it leaves those before it.
    int first = 0;
    for (std::size_t q = 0; q < p; ++q)
      first = std::max(first, shared_point_count(tree.paths[p], tree.paths[q]));
    const HealthyLine whole = line_of(tree.paths[p], healed[p], std::size_t(first));
    HealthyLine piece;  // stretches near the box
    for (std::size_t i = 0; i < whole.points.size(); ++i) {
      if (near_box(whole.points[i], box, kNearRadii * whole.radius[i])) {
        piece.points.push_back(whole.points[i]);
        piece.radius.push_back(whole.radius[i]);
        piece.narrowed.push_back(whole.narrowed[i]);
        piece.tangents.push_back(whole.tangents[i]);
        if (i + 1 < whole.points.size()) continue;
      }
      if (piece.points.size() > 1) lines_.push_back(std::move(piece));
      piece = {};
    }
  }
  if (lines_.empty())
    throw InputError(
        "no line of the centreline runs near the wall (nothing says where the vessel goes). Run "
        "the stages centerline and meshing again");
}

HealthyPlace HealthyVessel::evaluate(const Vec3& point) const {
  struct OfLine {
    double distance, radius, narrowed;
    Vec3 gradient, tangent;
  };
  std::vector<OfLine> found;
  double least = std::numeric_limits<double>::infinity();
  for (const HealthyLine& piece : lines_) {
    OfLine best{std::numeric_limits<double>::infinity(), 0.0, 0.0, {}, {}};
    for (std::size_t i = 0; i + 1 < piece.points.size(); ++i) {
      const Vec3 along = piece.points[i + 1] - piece.points[i];
      const double squared = norm_squared(along);
      const double t =
          squared > 0.0 ? std::clamp(dot(point - piece.points[i], along) / squared, 0.0, 1.0) : 0.0;
      const Vec3 from = point - (piece.points[i] + t * along);
      const double radius = (1.0 - t) * piece.radius[i] + t * piece.radius[i + 1];
      const double distance = norm(from) - radius;
      if (distance >= best.distance) continue;
      best = {distance, radius, (1.0 - t) * piece.narrowed[i] + t * piece.narrowed[i + 1],
              normalized(from), (1.0 - t) * piece.tangents[i] + t * piece.tangents[i + 1]};
    }
    least = std::min(least, best.distance);
    found.push_back(best);
  }
  HealthyPlace place;
  double sum = 0.0;
  for (const OfLine& of : found) {
    const double width = kBlendShare * of.radius;
    const double weight = std::exp(-std::min(50.0, (of.distance - least) / width));
    sum += weight;
    place.distance -= weight * width;  // the blend's width, weighted
    place.gradient += weight * of.gradient;
    place.radius += weight * of.radius;
    place.narrowed += weight * of.narrowed;
    place.tangent += weight * of.tangent;
  }
  place.distance = least + place.distance / sum * std::log(sum);
  place.gradient = place.gradient / sum;
  place.radius /= sum;
  place.narrowed /= sum;
  place.tangent = normalized(place.tangent);
  return place;
}

}  // namespace angio::meshing::detail

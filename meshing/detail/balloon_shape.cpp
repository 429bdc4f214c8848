#include "meshing/detail/balloon_shape.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "meshing/detail/balloon_axis.hpp"
#include "meshing/detail/fold_section.hpp"

namespace angio::meshing::detail {
namespace {

using std::numbers::pi;

constexpr double kGuidewireRadius = 0.18;  // [mm] of a 0.014 inch wire, the thinnest shaft
constexpr double kRingSlope = 0.4;         // by which neighbouring rings may differ
constexpr double kPitchPerGap = 1.25;      // chords take a fifth of the pitch, see fold_section
constexpr double kQuadAspect = 2.5;        // of the folded rings' quadrilaterals

std::string two_digits(double value) {
  const std::string text = std::to_string(value + 0.005);
  return text.substr(0, text.find('.') + 3);
}

/// A ring of the start shape, in polar coordinates around the axis.
struct StartRing {
  double position = 0.0;  ///< share of the axis's length
  std::vector<double> angle, radius;
};
struct StartShape {
  std::vector<StartRing> rings;
  std::vector<double> rest_angle;  ///< of a ring's vertices in the unloaded balloon
};

Balloon assemble(const BalloonPlan& plan, const FramedAxis& axis, const StartShape& shape) {
  const BalloonRings rest = balloon_rings(plan);
  Balloon balloon;
  balloon.nominal_diameter_mm = plan.nominal_diameter;
  balloon.length_mm = plan.cylinder_length;
  balloon.fold_count = plan.fold_count;
  balloon.ring_count = plan.ring_count;
  balloon.ring_vertex_count = plan.ring_vertex_count;
  balloon.start.triangles = balloon_triangles(plan.ring_count, plan.ring_vertex_count);
  for (std::size_t i = 0; i < shape.rings.size(); ++i) {
    const StartRing& ring = shape.rings[i];
    const AxisFrame frame = frame_at(axis, ring.position * axis.length());
    const Vec3 binormal = cross(frame.tangent, frame.normal);
    for (std::size_t k = 0; k < ring.angle.size(); ++k) {
      balloon.rest.push_back({rest.radius[i] * std::cos(shape.rest_angle[k]),
                              rest.radius[i] * std::sin(shape.rest_angle[k]), rest.position[i]});
      balloon.start.vertices.push_back(frame.point +
                                       ring.radius[k] * (std::cos(ring.angle[k]) * frame.normal +
                                                         std::sin(ring.angle[k]) * binormal));
      balloon.start_diameter_mm = std::max(balloon.start_diameter_mm, 2.0 * ring.radius[k]);
    }
    const int from_end = std::min(int(i), plan.ring_count - 1 - int(i));
    const bool is_tied = plan.ends == BalloonEnds::cones ? from_end < kNeckRings
                                                         : rest.radius[i] <= plan.shaft_radius;
    balloon.fixed.insert(balloon.fixed.end(), ring.angle.size(), is_tied ? 1 : 0);
    const bool slides = plan.ends == BalloonEnds::cones && int(i) >= plan.ring_count - kNeckRings;
    balloon.sliding.insert(balloon.sliding.end(), ring.angle.size(), slides ? 1 : 0);
  }
  balloon.rest.push_back({0.0, 0.0, 0.0});
  balloon.rest.push_back({0.0, 0.0, plan.total_length()});
  for (const Vec3& pole : {axis.points.front(), axis.points.back()}) {
    balloon.start.vertices.push_back(pole);
    balloon.fixed.push_back(1);
  }
  balloon.sliding.push_back(0);
  balloon.sliding.push_back(plan.ends == BalloonEnds::cones ? 1 : 0);
  for (int i = 0; i < plan.guidewire_node_count; ++i)
    balloon.guidewire.push_back(
        frame_at(axis, axis.length() * i / (plan.guidewire_node_count - 1)).point);
  return balloon;
}

AxisWish axis_wish(const BalloonPlan& plan, double radius) {
  return {plan.middle_abscissa, plan.total_length(), 0.5 * plan.rest_radius, radius};
}

// === Folds not meshed ===

/// Radii of the rings: as wide as wanted or as the wall lets them, and changing slowly.
std::vector<double> tube_radii(const BalloonPlan& plan, const BalloonRings& rest,
                               const FramedAxis& axis) {
  const double scale = axis.length() / plan.total_length();
  std::vector<double> radii;
  const std::size_t count = rest.position.size();
  for (std::size_t i = 0; i < count; ++i) {
    // The membrane between the neighbouring rings must fit as well.
    const double from = i > 0 ? rest.position[i - 1] * scale : 0.0;
    const double to = i + 1 < count ? rest.position[i + 1] * scale : axis.length();
    double radius = std::min(rest.radius[i], plan.start_radius);
    for (std::size_t p = 0; p < axis.points.size(); ++p)
      if (axis.abscissa[p] >= from - 1e-9 && axis.abscissa[p] <= to + 1e-9)
        radius = std::min(radius, axis.fitting_radius[p]);
    radii.push_back(radius);
  }
  for (std::size_t i = 1; i < count; ++i)
    radii[i] =
        std::min(radii[i], radii[i - 1] + kRingSlope * (rest.position[i] - rest.position[i - 1]));
  for (std::size_t i = count - 1; i > 0; --i)
    radii[i - 1] =
        std::min(radii[i - 1], radii[i] + kRingSlope * (rest.position[i] - rest.position[i - 1]));
  return radii;
}

ShapedBalloon shape_tube(const BalloonPlan& plan, const CenterlinePath& path,
                         const SurfaceTarget& wall) {
  const BalloonRings rest = balloon_rings(plan);
  const FramedAxis axis = fit_axis(axis_wish(plan, plan.start_radius), path, wall);
  if (axis.narrowest() < kLeastStartRadius)
    throw InputError(
        "the balloon does not fit through the lumen (at its narrowest place a radius of " +
        two_digits(std::max(0.0, axis.narrowest())) + " mm is free, " +
        two_digits(kLeastStartRadius) + " mm is needed: a lumen of at least " +
        two_digits(least_lumen_to_cross_mm()) +
        " mm in diameter for the crossing profile). Choose another place or a shorter balloon "
        "(balloon.length_mm), or check the segmentation there");
  const std::vector<double> radii = tube_radii(plan, rest, axis);
  StartShape shape;
  for (int k = 0; k < plan.ring_vertex_count; ++k)
    shape.rest_angle.push_back(2.0 * pi * k / plan.ring_vertex_count);
  for (std::size_t i = 0; i < radii.size(); ++i)
    shape.rings.push_back({rest.position[i] / plan.total_length(), shape.rest_angle,
                           std::vector<double>(shape.rest_angle.size(), plan.slimness * radii[i])});
  return {assemble(plan, axis, shape), {}};
}

// === Folds ===

/// The packing of the folds in a given room; the shaft gives way down to a guidewire.
///
/// @param room  radius that must not be exceeded [mm]; the start radius is not, where it can be
std::optional<FoldPack> pack_in(const BalloonPlan& plan, double room) {
  const double perimeter = 2.0 * pi * plan.rest_radius;
  const double wished = std::min(room, plan.start_radius);
  constexpr int kSteps = 8;
  for (int step = 0; step <= kSteps; ++step) {
    const double shaft =
        plan.shaft_radius + step * std::min(0.0, kGuidewireRadius - plan.shaft_radius) / kSteps;
    const auto pack = pack_folds(plan.fold_count, perimeter, shaft + plan.fold_gap,
                                 kPitchPerGap * plan.fold_gap, wished);
    if (pack && pack->outer_radius() <= room) return pack;
  }
  return std::nullopt;
}

/// Enough vertices for the folds.
void refine_for_folds(BalloonPlan& plan, const FoldPack& pack) {
  const double perimeter = 2.0 * pi * plan.rest_radius;
  const int step = 2 * plan.fold_count;
  plan.ring_vertex_count = std::max(folded_ring_vertex_count(pack, perimeter),
                                    (plan.ring_vertex_count + step - 1) / step * step);
  const double meridian = plan.meridian();
  const double spacing = kQuadAspect * perimeter / plan.ring_vertex_count;
  plan.ring_count = std::max(plan.ring_count, int(std::ceil(meridian / spacing)) - 1);
}

/// The rings of the folded start. In the ends the folds open halfway between evenly along the
/// meridian and as late as the length of their layers lets them: so no layer is stretched, neither
/// around nor along. Rings no wider than the core are as unloaded; those between are at equal
/// steps.
StartShape fold_rings(const BalloonPlan& plan, const FoldPack& pack) {
  const BalloonRings rest = balloon_rings(plan);
  const double widest = *std::max_element(rest.radius.begin(), rest.radius.end());
  const FoldedSection section = fold_section(pack, widest, plan.ring_vertex_count);
  const double open_past = plan.meridian_to(pack.core_radius * plan.rest_radius / widest);
  const double open_rise = plan.rise(open_past);
  StartShape shape;
  shape.rest_angle = section.rest_angle;
  for (std::size_t i = 0; i < rest.radius.size(); ++i) {
    const double past = rest.past_end[i];
    const double share = std::min(1.0, past / open_past);
    FoldedSection at = section;
    double position = rest.position[i];
    if (share >= 1.0) {
      at = section.opened(1.0);
      at.radius.assign(at.radius.size(), rest.radius[i]);
    } else if (share > 0.0) {
      at = section.opened(0.5 * (share + section.opening_at(rest.radius[i])));
      const bool first_end = 2 * i < rest.radius.size();
      const double on_end = share * open_rise;
      position = first_end ? plan.end_length() - on_end
                           : plan.end_length() + plan.cylinder_length + on_end;
    }
    shape.rings.push_back({position / plan.total_length(), at.angle, at.radius});
  }
  return shape;
}

ShapedBalloon shape_folded(BalloonPlan plan, const CenterlinePath& path,
                           const SurfaceTarget& wall) {
  const auto loosest = pack_in(plan, 1e3);
  if (!loosest)
    throw InputError("a balloon of " + two_digits(plan.nominal_diameter) + " mm is too small for " +
                     std::to_string(plan.fold_count) +
                     " folds (its circumference is little more than the shaft's). Choose fewer "
                     "folds (balloon.folds) or a thinner shaft (balloon.shaft_diameter_mm)");
  const FramedAxis axis = fit_axis(axis_wish(plan, loosest->outer_radius()), path, wall);
  const double room = plan.slimness * axis.narrowest();
  const auto pack = pack_in(plan, room);
  if (!pack)
    throw InputError(
        "the folded balloon does not fit through the lumen (at its narrowest place a radius of " +
        two_digits(std::max(0.0, room)) +
        " mm is free). Choose a smaller balloon (balloon.nominal_diameter_mm), another place, or "
        "the unfolded start (balloon.folds = 0)");
  ShapedBalloon result;
  if (pack->outer_radius() > 1.001 * plan.start_radius)
    result.warnings.push_back("the folded balloon is " + two_digits(2.0 * pack->outer_radius()) +
                              " mm thick at the start, more than the " +
                              two_digits(2.0 * plan.start_radius) +
                              " mm wished: its layers cannot be packed more tightly");
  const double shaft = pack->core_radius - plan.fold_gap;
  if (shaft < plan.shaft_radius - 1e-9)
    result.warnings.push_back("the shaft inside the folds was made thinner, " +
                              two_digits(2.0 * shaft) + " mm instead of " +
                              two_digits(2.0 * plan.shaft_radius) +
                              " mm, so that the balloon fits through the lumen");
  plan.shaft_radius = shaft;
  plan.neck_radius = std::min(plan.neck_radius, shaft);
  refine_for_folds(plan, *pack);
  result.balloon = assemble(plan, axis, fold_rings(plan, *pack));
  result.balloon.shaft_diameter_mm = 2.0 * shaft;
  return result;
}

}  // namespace

ShapedBalloon shape_balloon(const BalloonPlan& plan, const CenterlinePath& path,
                            const SurfaceTarget& wall) {
  return plan.fold_count > 0 ? shape_folded(plan, path, wall) : shape_tube(plan, path, wall);
}

}  // namespace angio::meshing::detail

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "air_mesh/build/gap_boundary.hpp"
#include "air_mesh/build/gap_mesh.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "meshing/detail/balloon_axis.hpp"
#include "meshing/detail/balloon_shape.hpp"
#include "meshing/detail/contact_region.hpp"
#include "meshing/detail/winding.hpp"
#include "meshing/detail/wire_beyond.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing {
namespace {

using detail::BalloonPlan;

constexpr double kShoulder = 3.0;          // [mm] the balloon's cylinder reaches past the lesion
constexpr double kLeastCylinder = 8.0;     // [mm] by default, and no less than a diameter
constexpr double kShortestSold = 5.0;      // [mm] and no less than a diameter
constexpr double kShortestCylinder = 2.0;  // [mm] ever
// By default no balloon is longer than those that are sold: 30 mm in coronaries, longer where the
// vessel is wider.
constexpr double kLongestCoronary = 30.0, kLongestInDiameters = 8.0, kLongestSold = 80.0;
constexpr double kDiameterStep = 0.25;  // [mm] in which balloons are sold
constexpr double kLeastDiameter = 1.0;  // [mm] by default
// Diameter of a folded balloon [mm]: of coronary ones, up to kMostCoronary. A wider one has more
// membrane around a thicker shaft: 2.3 mm at 16 mm, 3.1 mm at 25 mm, as 7 and 9 French sheaths
// take.
constexpr double kCrossingProfile = 0.9, kMostCoronary = 4.0;
constexpr double kWidestNeck = 0.8;  // of the balloon's radius
// A full balloon is stiff. Over one that is chosen the line turns by no more than 45 degrees, from
// which on a segment counts as angulated, if that still covers the lesion; and never by more than
// 90, extremely angulated: there it would kink, or draw the two legs of the vessel together. The
// classes are those of ACC and AHA (Ryan et al., Circulation 78 (1988) 486).
constexpr double kAngulatedDegrees = 45.0, kMostTurnDegrees = 90.0;

struct Lesion {
  double abscissa, length, reference_diameter;
};

std::string millimetres(double value) {
  std::string text = std::to_string(std::round(100.0 * value) / 100.0);
  return text.substr(0, text.find('.') + 3) + " mm";
}

/// The part of the path inside the open lumen: from the inlet's cap to the outlet's.
struct OpenStretch {
  double first, last;
};
OpenStretch open_stretch(const LumenMesh& lumen, const CenterlineTree& tree,
                         const CenterlinePath& path) {
  OpenStretch stretch{path.abscissa.front(), path.abscissa.back()};
  int outlet_id = -1;
  for (std::size_t p = 0; p < tree.paths.size(); ++p)
    if (tree.paths[p].id == path.id) outlet_id = int(p) + 2;
  // Of the vertices inside a cap, away from its rim, the line runs through the one that is nearest
  // to it.
  std::vector<char> is_at_wall(lumen.capped.vertices.size(), 0);
  for (const Triangle& t : lumen.capped.triangles) {
    const auto is_walls = [&](int v) { return lumen.inlet_outlet_id[std::size_t(v)] == 0; };
    if (std::any_of(t.begin(), t.end(), is_walls))
      for (const int v : t) is_at_wall[std::size_t(v)] = 1;
  }
  double off_first = std::numeric_limits<double>::infinity(), off_last = off_first;
  for (std::size_t v = 0; v < lumen.capped.vertices.size(); ++v) {
    const int id = lumen.inlet_outlet_id[v];
    if (is_at_wall[v] || (id != 1 && id != outlet_id)) continue;
    const double s = project(path, lumen.capped.vertices[v]);
    const double off = distance(sample(path, s).point, lumen.capped.vertices[v]);
    double& nearest = id == 1 ? off_first : off_last;
    if (off >= nearest) continue;
    nearest = off;
    (id == 1 ? stretch.first : stretch.last) = s;
  }
  return stretch;
}

double crossing_profile(double nominal_diameter) {
  return kCrossingProfile * std::pow(std::max(1.0, nominal_diameter / kMostCoronary), 2.0 / 3.0);
}

std::string shortened_text(const BalloonPlan& plan, double wished) {
  const char* unsold = plan.cylinder_length < shortest_balloon_length_mm(2.0 * plan.rest_radius)
                           ? " (none so short is sold in this diameter)"
                           : "";
  return "the balloon was shortened from " + millimetres(wished) + " to " +
         millimetres(plan.cylinder_length) +
         " to stay one diameter inside the open ends; for a longer one, segment more of the "
         "vessel" +
         unsold;
}

/// Fills in the defaults and keeps the balloon a local diameter away from the open ends.
BalloonPlan make_plan(const BalloonOptions& options, const Lesion& lesion,
                      const OpenStretch& stretch, const CenterlinePath& path,
                      std::vector<std::string>& warnings) {
  BalloonPlan plan;
  plan.ring_count = options.ring_count;
  plan.ring_vertex_count = options.ring_vertex_count;
  plan.guidewire_node_count = options.guidewire_node_count;
  plan.fold_count = options.folds;
  plan.shaft_radius = options.folds > 0 ? 0.5 * options.shaft_diameter_mm : 0.0;
  plan.fold_gap = options.fold_gap_mm;
  plan.nominal_diameter = options.nominal_diameter_mm > 0.0
                              ? options.nominal_diameter_mm
                              : usual_balloon_diameter_mm(lesion.reference_diameter);
  plan.rest_radius =
      0.5 * (options.rest_diameter_mm > 0.0 ? options.rest_diameter_mm : plan.nominal_diameter);
  plan.start_radius =
      0.5 * (options.start_diameter_mm > 0.0 ? options.start_diameter_mm
                                             : crossing_profile(plan.nominal_diameter));
  plan.ends = options.ends;
  // A shaft is thicker where the folded balloon is; it is no thicker than that, and the balloon
  // wider.
  plan.neck_radius = std::min(
      {0.5 * options.shaft_diameter_mm * crossing_profile(plan.nominal_diameter) / kCrossingProfile,
       plan.start_radius, kWidestNeck * plan.rest_radius});
  const double wished = options.length_mm > 0.0
                            ? options.length_mm
                            : usual_balloon_length_mm(lesion.length, plan.nominal_diameter);
  const auto diameter_at = [&](double s) { return 2.0 * sample(path, s).inscribed_radius; };
  const double first = stretch.first + diameter_at(stretch.first);
  const double last = stretch.last - diameter_at(stretch.last);
  if (first > last)
    throw InputError("the vessel is too short for a balloon: nowhere on its line, of " +
                     millimetres(stretch.last - stretch.first) +
                     ", is one lumen diameter free to each open end (the wall is held there, and "
                     "the balloon would reach out of the vessel). Segment more of the vessel");
  if (lesion.abscissa < first || lesion.abscissa > last)
    throw InputError("the place for the balloon, abscissa " + millimetres(lesion.abscissa) +
                     ", lies within one lumen diameter of an open end (the wall is held there, and "
                     "the balloon would reach out of the vessel). Choose a place from " +
                     millimetres(first) + " to " + millimetres(last) +
                     " (lesion.abscissa_mm), or segment more of the vessel");
  // Near an end the balloon may move along the line as long as it covers the lesion.
  const double play = std::max(0.0, 0.5 * (wished - lesion.length));
  const double half = 0.5 * wished + plan.end_length();
  plan.middle_abscissa = lesion.abscissa;
  if (lesion.abscissa - half < first)
    plan.middle_abscissa = std::min(first + half, lesion.abscissa + play);
  if (lesion.abscissa + half > last)
    plan.middle_abscissa = std::max(last - half, lesion.abscissa - play);
  if (2.0 * half > last - first) plan.middle_abscissa = 0.5 * (first + last);
  const double room = 2.0 * std::min(plan.middle_abscissa - first, last - plan.middle_abscissa);
  plan.cylinder_length = std::min(wished, room - 2.0 * plan.end_length());
  if (plan.cylinder_length < kShortestCylinder)
    throw InputError("the line is too short for a balloon of " +
                     millimetres(plan.nominal_diameter) + " diameter at abscissa " +
                     millimetres(lesion.abscissa) +
                     " (one lumen diameter must stay free to each open end). Choose another place, "
                     "a smaller balloon (balloon.nominal_diameter_mm), or segment more of the "
                     "vessel");
  if (plan.cylinder_length < wished - 1e-9) warnings.push_back(shortened_text(plan, wished));
  return plan;
}

/// The start shape; thinner until it is clear of the wall, with more rings until it is of itself.
detail::ShapedBalloon shape_clear(BalloonPlan plan, const CenterlinePath& path,
                                  const TriangleMesh& lumen) {
  constexpr int kAttempts = 5;
  const detail::MeshTarget wall(lumen);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    detail::ShapedBalloon shaped = detail::shape_balloon(plan, path, wall);
    const Balloon& balloon = shaped.balloon;
    const bool crosses_itself = count_self_intersections(balloon.start) > 0;
    if (!crosses_itself && count_intersections(balloon.start, lumen) == 0) return shaped;
    // Folds that run out cross where they turn too far from one ring to the next.
    if (crosses_itself && plan.fold_count > 0)
      plan.ring_count = balloon.ring_count * 4 / 3;
    else
      plan.slimness *= 0.85;
  }
  throw InputError(
      "the balloon cannot be placed without touching the wall (the line bends too sharply there). "
      "Choose another place, a shorter balloon (balloon.length_mm) or a smaller one "
      "(balloon.nominal_diameter_mm)");
}

/// The greatest angle between two directions of a line [degrees].
double turn_of(const std::vector<Vec3>& line) {
  std::vector<Vec3> directions;
  for (std::size_t i = 1; i < line.size(); ++i)
    directions.push_back(normalized(line[i] - line[i - 1]));
  double least = 1.0;
  for (const Vec3& a : directions)
    for (const Vec3& b : directions) least = std::min(least, dot(a, b));
  return std::acos(std::clamp(least, -1.0, 1.0)) * 180.0 / units::kPi;
}

/// The start shape of a balloon that does not reach around a bend: by default it is shortened about
/// the lesion, as far as that stays covered, until the line is not angulated over it, and further
/// until it is not extremely so.
detail::ShapedBalloon shape_in_bend(BalloonPlan& plan, const Lesion& lesion, bool is_length_given,
                                    const CenterlinePath& path, const TriangleMesh& lumen,
                                    std::vector<std::string>& warnings) {
  constexpr double kShorter = 0.85;
  const double wished = plan.cylinder_length;
  const double shortest = std::min(wished, shortest_balloon_length_mm(2.0 * plan.rest_radius));
  detail::ShapedBalloon shaped = shape_clear(plan, path, lumen);
  double turn = turn_of(shaped.balloon.guidewire);
  const double covering = std::max(shortest, std::min(wished, lesion.length));
  const auto least_length = [&] { return turn > kMostTurnDegrees ? shortest : covering; };
  while (turn > kAngulatedDegrees && !is_length_given && plan.cylinder_length > least_length()) {
    plan.cylinder_length = std::max(least_length(), kShorter * plan.cylinder_length);
    const double play = std::max(0.0, 0.5 * (plan.cylinder_length - lesion.length));
    plan.middle_abscissa =
        std::clamp(plan.middle_abscissa, lesion.abscissa - play, lesion.abscissa + play);
    shaped = shape_clear(plan, path, lumen);
    turn = turn_of(shaped.balloon.guidewire);
  }
  if (plan.cylinder_length < wished)
    warnings.push_back("the balloon was shortened from " + millimetres(wished) + " to " +
                       millimetres(plan.cylinder_length) +
                       ": over a longer one the vessel turns by more than " +
                       std::to_string(std::lround(kAngulatedDegrees)) +
                       " degrees (balloon.length_mm asks for one all the same)");
  if (turn > kMostTurnDegrees)
    warnings.push_back("the vessel turns by " + std::to_string(std::lround(turn)) +
                       " degrees along the balloon: a real one would straighten it further than "
                       "this wall gives way");
  return shaped;
}

/// Whether a closed surface holds all of a balloon. A region can come out as a scrap of wall beside
/// it, where vessels touch or a cap takes much away: that wall would never be met.
bool encloses(const TriangleMesh& shell, const TriangleMesh& balloon) {
  const detail::Winding winding(shell);
  return std::all_of(balloon.vertices.begin(), balloon.vertices.end(),
                     [&](const Vec3& p) { return std::abs(winding.at(p)) == 1; });
}

struct ClosedRegion {
  ContactRegion region;
  air_mesh::GapBoundary gap;
};

/// Holds the wall that is further from the balloon's axis than kReach radii, of the full balloon or
/// of the lumen around it, whichever is wider. Sections that keep clear of forks, and branches that
/// fork again and again, take in wall that hardly gives way.
///
/// A tube that is pushed apart at one place comes back within the envelope e^(-x / l) along it,
///
///     l = sqrt(R h) / (3 (1 - nu^2))^(1/4) = 0.7 r
///
/// for its middle surface R = 1.3 r, the default wall h = 0.6 r of a lumen of the radius r, and
/// nu = 1/2: at the distance 2 r from the balloon's side 6 % is left. The bending of the whole
/// vessel reaches further, but the region's sections are as near to the poles as that, too.
///
/// Source: Timoshenko, Woinowsky-Krieger, Theory of plates and shells, 1959, section 114
void hold_far_wall(ContactRegion& region, const CenterlinePath& path, double first_pole,
                   double last_pole, double balloon_radius) {
  constexpr double kReach = 3.0;
  std::vector<Vec3> axis;
  double widest = balloon_radius;
  const int steps = std::max(1, int(std::ceil((last_pole - first_pole) / (0.5 * balloon_radius))));
  for (int i = 0; i <= steps; ++i) {
    const CenterlineSample at =
        sample(path, first_pole + (last_pole - first_pole) * double(i) / double(steps));
    axis.push_back(at.point);
    widest = std::max(widest, at.inscribed_radius);
  }
  const double reach_squared = kReach * kReach * widest * widest;
  for (std::size_t v = 0; v < region.mesh.vertices.size(); ++v)
    if (std::none_of(axis.begin(), axis.end(), [&](const Vec3& p) {
          return norm_squared(region.mesh.vertices[v] - p) <= reach_squared;
        }))
      region.fixed[v] = 1;
}

/// The wall around the balloon, from about a diameter before it to a diameter past it; further
/// where the ends there could not be closed clear of the balloon.
ClosedRegion find_region(const LumenMesh& lumen, const CenterlineTree& tree,
                         const CenterlinePath& path, const Balloon& balloon,
                         double balloon_radius) {
  const std::size_t last_vertex = balloon.start.vertices.size() - 1;
  const double first_pole = project(path, balloon.start.vertices[last_vertex - 1]);
  const double last_pole = project(path, balloon.start.vertices[last_vertex]);
  for (const double diameters : {1.0, 1.4, 0.7, 2.0, 3.0}) {
    const detail::RegionExtent extent{
        &path, first_pole - diameters * 2.0 * sample(path, first_pole).inscribed_radius,
        last_pole + diameters * 2.0 * sample(path, last_pole).inscribed_radius};
    ContactRegion region = detail::extract_region(lumen.open, tree, extent, balloon.guidewire);
    auto closed = air_mesh::close_wall(region.mesh);
    if (!closed || count_intersections(balloon.start, closed->boundary.shell) > 0 ||
        !encloses(closed->boundary.shell, balloon.start))
      continue;
    if (closed->wall_vertex.size() < region.mesh.vertices.size())
      region = detail::with_triangles(region, closed->wall_triangles());
    hold_far_wall(region, path, first_pole, last_pole, balloon_radius);
    return {std::move(region), std::move(closed->boundary)};
  }
  throw InputError(
      "the wall around the balloon was not found, or its ends could not be closed clear of the "
      "balloon (a branch, a kink or touching vessels lie there). Move the balloon along the line "
      "or make it shorter (balloon.length_mm)");
}

}  // namespace

double usual_balloon_diameter_mm(double reference_diameter_mm) {
  return std::max(kLeastDiameter,
                  kDiameterStep * std::round(reference_diameter_mm / kDiameterStep));
}

double usual_balloon_length_mm(double lesion_length_mm, double nominal_diameter_mm) {
  const double longest =
      std::clamp(kLongestInDiameters * nominal_diameter_mm, kLongestCoronary, kLongestSold);
  const double wished = std::ceil(lesion_length_mm + 2.0 * kShoulder - 1e-9);
  return std::clamp(wished, std::max(kLeastCylinder, nominal_diameter_mm), longest);
}

double shortest_balloon_length_mm(double diameter_mm) {
  return std::max(kShortestSold, diameter_mm);
}

double least_lumen_to_cross_mm() { return 2.0 * detail::room_for(detail::kLeastStartRadius); }

BalloonSetup place_balloon(const LumenMesh& lumen, const CenterlineTree& tree,
                           const CenterlinePath& path, double abscissa_mm, double lesion_length_mm,
                           double reference_diameter_mm, const BalloonOptions& options,
                           const Progress& progress) {
  options.validate();
  if (path.points.size() < 2)
    throw InputError(
        "the line for the balloon has less than two points. Run the stage centerline "
        "again");
  BalloonSetup setup;
  progress.report(0.0, "balloon");
  const Lesion lesion{abscissa_mm, lesion_length_mm, reference_diameter_mm};
  BalloonPlan plan =
      make_plan(options, lesion, open_stretch(lumen, tree, path), path, setup.warnings);
  detail::ShapedBalloon shaped =
      shape_in_bend(plan, lesion, options.length_mm > 0.0, path, lumen.open, setup.warnings);
  setup.balloon = std::move(shaped.balloon);
  setup.warnings.insert(setup.warnings.end(), shaped.warnings.begin(), shaped.warnings.end());
  detail::extend_wire(path, 0.5 * plan.rest_radius, setup.balloon);

  progress.report(0.3, "contact region");
  ClosedRegion closed = find_region(lumen, tree, path, setup.balloon,
                                    std::max(plan.rest_radius, 0.5 * plan.nominal_diameter));
  setup.region = std::move(closed.region);

  progress.report(0.6, "air mesh");
  const Vec3 hole = setup.balloon.guidewire[setup.balloon.guidewire.size() / 2];
  air_mesh::GapMesh air = air_mesh::mesh_gap(setup.balloon.start, closed.gap, hole);
  if (air.flat_at_inner) {  // folds of exactly flat layers leave flat tets between them
    TriangleMesh uneven = air_mesh::shaken(setup.balloon.start);
    air_mesh::GapMesh again = air_mesh::mesh_gap(uneven, closed.gap, hole);
    if (again.warnings.empty()) {
      setup.balloon.start = std::move(uneven);
      air = std::move(again);
    }
  }
  setup.air.tets = std::move(air.tets);
  setup.warnings.insert(setup.warnings.end(), air.warnings.begin(), air.warnings.end());
  progress.report(1.0);
  return setup;
}

}  // namespace angio::meshing

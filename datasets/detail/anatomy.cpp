#include "datasets/detail/anatomy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "datasets/detail/vessel_plan.hpp"

namespace angio::datasets::detail {
namespace {

constexpr double kLesionLengthInRadii = 6.0;

/// Sizes: large epicardial arteries (all but coronary); left main, LAD, LCx
/// and diagonal after Dodge et al., Circulation 86:232, 1992 (left main 4.5 mm, proximal LAD 3.7
/// mm).
constexpr std::array<DefaultSize, 12> kDefaultSizes{{
    {"straight", 1.5, 40.0, 4.0},
    {"concentric", 1.5, 40.0, 9.0},
    {"unilateral", 1.5, 40.0, 9.0},
    {"bilateral", 1.5, 40.0, 9.0},
    {"tandem", 1.5, 50.0, 30.0},
    {"helix", 1.5, 60.0, 40.0},
    {"torus", 1.5, 45.0, 26.0},
    {"ytype", 1.8, 45.0, 18.0},
    {"trifurcation", 1.8, 45.0, 20.0},
    {"aneurysm", 1.5, 50.0, 30.0},
    {"coronary", 2.1, 70.0, 25.0},
    {"cloth", 0.0, 50.0, 0.0},
}};

/// What both daughters get by Murray's law, where the smaller is `ratio` times the larger.
struct Daughters {
  double larger;
  double smaller;
};
Daughters divide_by_murray(double parent_radius, double ratio) {
  const double larger = parent_radius / std::cbrt(1.0 + ratio * ratio * ratio);
  return {larger, ratio * larger};
}

VesselPlan straight_plan(const PhantomOptions& options) {
  VesselPlan plan;
  const double length = options.length_mm, radius = options.radius_mm;
  plan.start = {0.0, 0.0, 0.5 * length};
  plan.length_mm = length;
  plan.directions = {{0.0, {0.0, 0.0, -1.0}}};
  plan.radii = {{0.0, length, radius, radius, 0.0}};
  return plan;
}

LesionPlan lesion_at(double center_mm, double radius_mm, const PhantomOptions& options,
                     const Vec3& toward, LesionShape shape) {
  return {center_mm, kLesionLengthInRadii * radius_mm, options.stenosis_percent / 100.0, toward,
          shape};
}

/// One vessel with its lesions, none if no stenosis is asked for.
Anatomy make_vessel(VesselPlan plan, const PhantomOptions& options,
                    const std::vector<LesionPlan>& lesions) {
  std::vector<LesionSite> sites;
  if (options.stenosis_percent > 0.0) plan.lesions = lesions;
  for (const LesionPlan& lesion : plan.lesions)
    sites.push_back({0, lesion.center_mm, lesion.length_mm});
  return {LumenShape({sample_vessel(plan)}), sites};
}

Anatomy make_tube(const PhantomOptions& options) {
  const VesselPlan plan = straight_plan(options);
  if (options.name == "straight") return make_vessel(plan, options, {});
  const LesionShape shape = options.name == "concentric"  ? LesionShape::concentric
                            : options.name == "bilateral" ? LesionShape::two_sided
                                                          : LesionShape::eccentric;
  return make_vessel(
      plan, options,
      {lesion_at(0.5 * plan.length_mm, options.radius_mm, options, {1.0, 0.0, 0.0}, shape)});
}

/// Two stenoses on opposite walls; the second is three quarters as deep.
Anatomy make_tandem(const PhantomOptions& options) {
  const VesselPlan plan = straight_plan(options);
  PhantomOptions milder = options;
  milder.stenosis_percent *= 0.75;
  return make_vessel(plan, options,
                     {lesion_at(plan.length_mm / 3.0, options.radius_mm, options, {1.0, 0.0, 0.0},
                                LesionShape::eccentric),
                      lesion_at(plan.length_mm * 2.0 / 3.0, options.radius_mm, milder,
                                {-1.0, 0.0, 0.0}, LesionShape::eccentric)});
}

/// Directions along a curve given by its tangent, dense enough for the spline between them.
template <class Tangent>
std::vector<DirectionKey> follow_tangent(double length_mm, double key_distance_mm,
                                         const Tangent& tangent) {
  std::vector<DirectionKey> keys;
  const int key_count = int(std::ceil(length_mm / key_distance_mm));
  for (int k = -2; k <= key_count + 2; ++k) {  // past the ends, where the spline runs straight
    const double s = length_mm * k / key_count;
    keys.push_back({s, tangent(s)});
  }
  return keys;
}

/// A helix around z with a concentric stenosis in its middle: radius of the coil 5.3 vessel radii,
/// pitch two coil radii, so the axis bends with a radius of 5.8 vessel radii.
Anatomy make_helix(const PhantomOptions& options) {
  const double coil = 5.3 * options.radius_mm;
  const double rise = coil / units::kPi;  // per radian
  const double turn_length = std::hypot(coil, rise);
  VesselPlan plan = straight_plan(options);
  plan.start = {coil, 0.0, 0.0};
  plan.directions = follow_tangent(plan.length_mm, 0.1 * turn_length, [&](double s) {
    const double angle = s / turn_length;
    return Vec3{-coil * std::sin(angle), coil * std::cos(angle), -rise};
  });
  return make_vessel(plan, options,
                     {lesion_at(0.5 * plan.length_mm, options.radius_mm, options, {0.0, 0.0, 1.0},
                                LesionShape::concentric)});
}

/// Three quarters of a circle with a stenosis on the outer wall in its middle.
Anatomy make_torus(const PhantomOptions& options) {
  VesselPlan plan = straight_plan(options);
  const double bend = plan.length_mm / (1.5 * units::kPi);
  plan.start = {bend, 0.0, 0.0};
  plan.directions = follow_tangent(plan.length_mm, 0.1 * bend, [&](double s) {
    return Vec3{-std::sin(s / bend), std::cos(s / bend), 0.0};
  });
  const double middle_angle = 0.75 * units::kPi;
  const Vec3 inward{-std::cos(middle_angle), -std::sin(middle_angle), 0.0};
  return make_vessel(plan, options,
                     {lesion_at(0.5 * plan.length_mm, options.radius_mm, options, inward,
                                LesionShape::eccentric)});
}

/// A side branch that leaves `parent` at an abscissa: it starts along the parent with the parent's
/// radius and within `turn_mm` takes its own direction and radius.
struct SideBranch {
  double length_mm = 0.0;
  double turn_mm = 0.0;
  double radius_at_start_mm = 0.0;
  double radius_at_end_mm = 0.0;
  std::vector<DirectionKey> directions;  ///< after the turn
};
Branch leave(const std::vector<Branch>& branches, int parent, const VesselPlan& parent_plan,
             double abscissa_mm, const SideBranch& side) {
  const Branch& from = branches[std::size_t(parent)];
  const int sample = sample_at(from, abscissa_mm);
  const double exact_abscissa = (sample - from.first_sample) * from.step_mm;
  const double parent_radius = from.radius[std::size_t(sample)];
  VesselPlan plan;
  plan.begins_in_parent = true;
  plan.start = from.center[std::size_t(sample)];
  plan.length_mm = side.length_mm;
  plan.directions = {{0.0, parent_plan.direction(exact_abscissa)}};
  plan.directions.insert(plan.directions.end(), side.directions.begin(), side.directions.end());
  // A stretch of no length before the branch gives the radius that it starts from.
  plan.radii = {
      {-1.0, 0.0, parent_radius, parent_radius, 0.0},
      {0.0, side.length_mm, side.radius_at_start_mm, side.radius_at_end_mm, side.turn_mm}};
  Branch branch = sample_vessel(plan);
  branch.parent = parent;
  branch.parent_sample = sample;
  branch.blend_mm = 0.8 * side.radius_at_start_mm;
  return branch;
}

/// Where on the main branch the balls of a side branch no longer meet its own.
double separation_mm(const Branch& main, const Branch& side) {
  for (int s = side.parent_sample; s <= main.last_sample; ++s) {
    bool apart = true;
    for (int t = side.first_sample; t <= side.last_sample && apart; ++t)
      apart = distance(main.center[std::size_t(s)], side.center[std::size_t(t)]) >
              main.radius[std::size_t(s)] + side.radius[std::size_t(t)];
    if (apart) return (s - main.first_sample) * main.step_mm;
  }
  return (main.last_sample - main.first_sample) * main.step_mm;
}

/// A trunk that runs down and divides into equal daughters, each 35 degrees off its axis (with
/// three, 40 degrees), evenly around it, the first towards -x. The first one's stenosis begins on
/// its outer wall just past the carina.
Anatomy make_fork(const PhantomOptions& options, int daughter_count) {
  const double radius = options.radius_mm;
  const double trunk = 0.35 * options.length_mm;
  const double daughter_radius = radius / std::cbrt(double(daughter_count));  // Murray's law
  const double turn = 3.0 * radius;
  const double angle = (daughter_count == 2 ? 35.0 : 40.0) * units::kPi / 180.0;
  const auto daughter_direction = [&](int daughter) {
    const double around = units::kPi + 2.0 * units::kPi * daughter / daughter_count;
    return Vec3{std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around),
                -std::cos(angle)};
  };
  VesselPlan main = straight_plan(options);
  main.directions = {{trunk, {0.0, 0.0, -1.0}}, {trunk + turn, daughter_direction(0)}};
  main.radii = {{0.0, trunk, radius, radius, 0.0},
                {trunk, options.length_mm, daughter_radius, daughter_radius, turn}};
  const auto grow = [&] {
    std::vector<Branch> branches{sample_vessel(main)};
    for (int daughter = 1; daughter < daughter_count; ++daughter)
      branches.push_back(leave(branches, 0, main, trunk,
                               {options.length_mm - trunk,
                                turn,
                                daughter_radius,
                                daughter_radius,
                                {{turn, daughter_direction(daughter)}}}));
    return branches;
  };
  const std::vector<Branch> healthy = grow();
  if (options.stenosis_percent <= 0.0) return {LumenShape(healthy), {}};

  double carina = 0.0;
  for (std::size_t b = 1; b < healthy.size(); ++b)
    carina = std::max(carina, separation_mm(healthy[0], healthy[b]));
  const double lesion_length = kLesionLengthInRadii * daughter_radius;
  const double center = carina + 0.5 * lesion_length;
  main.lesions = {
      lesion_at(center, daughter_radius, options, {-1.0, 0.0, 0.0}, LesionShape::eccentric)};
  return {LumenShape(grow()), {{0, center, lesion_length}}};
}

/// A straight vessel, a saccular aneurysm on its side in the first third (neck 0.7 and
/// dome 2 vessel radii), and a concentric stenosis in the last third.
Anatomy make_aneurysm(const PhantomOptions& options) {
  const double radius = options.radius_mm;
  VesselPlan main = straight_plan(options);
  const LesionPlan lesion = lesion_at(main.length_mm * 2.0 / 3.0, radius, options, {1.0, 0.0, 0.0},
                                      LesionShape::concentric);
  Anatomy anatomy = make_vessel(main, options, {lesion});
  std::vector<Branch> branches = anatomy.shape.branches();

  VesselPlan sac;
  sac.begins_in_parent = sac.ends_as_dome = true;
  const int sample = sample_at(branches[0], main.length_mm * 0.3);
  sac.start = branches[0].center[std::size_t(sample)];
  sac.length_mm = 3.4 * radius;
  sac.directions = {{0.0, {1.0, 0.0, 0.0}}};
  sac.radii = {{0.0, 1.2 * radius, 0.7 * radius, 0.7 * radius, 0.0},
               {1.2 * radius, sac.length_mm, 2.0 * radius, 2.0 * radius, 2.2 * radius}};
  Branch branch = sample_vessel(sac);
  branch.parent = 0;
  branch.parent_sample = sample;
  branch.blend_mm = 0.5 * radius;
  branches.push_back(std::move(branch));
  anatomy.shape = LumenShape(std::move(branches));
  return anatomy;
}

/// A left coronary: the left main runs to the left; the LAD turns forward and down to the apex; the
/// circumflex (LCx) turns back; a diagonal leaves the LAD. The stenosis is in the LAD between both
/// bifurcations, on the wall away from the circumflex.
Anatomy make_coronary(const PhantomOptions& options) {
  const double k = options.length_mm / default_size("coronary").length_mm;
  const double radius = options.radius_mm;
  const double first_fork = 10.0 * k, second_fork = 32.0 * k;
  const double left_main_end = 0.975 * radius;
  const Daughters lad_lcx = divide_by_murray(left_main_end, 0.9);
  const double lad_proximal_end = 0.92 * lad_lcx.larger;
  const Daughters lad_diagonal = divide_by_murray(lad_proximal_end, 0.7);

  VesselPlan main;
  main.start = {-8.0 * k, 6.0 * k, 24.0 * k};
  main.length_mm = options.length_mm;
  main.directions = {{0.0, {0.93, -0.30, 0.10}},       {first_fork, {0.95, -0.20, -0.20}},
                     {18.0 * k, {0.62, -0.70, -0.36}}, {30.0 * k, {0.52, -0.45, -0.72}},
                     {45.0 * k, {0.28, -0.28, -0.92}}, {58.0 * k, {0.22, 0.12, -0.97}},
                     {70.0 * k, {-0.10, 0.30, -0.95}}};
  main.radii = {
      {0.0, first_fork, radius, left_main_end, 0.0},
      {first_fork, second_fork, lad_lcx.larger, lad_proximal_end, 2.5 * radius},
      {second_fork, main.length_mm, lad_diagonal.larger, 0.68 * lad_diagonal.larger, 2.5 * radius}};
  const double lesion_center = 22.0 * k;
  const double lesion_radius = main.healthy_radius(lesion_center);
  std::vector<LesionSite> sites;
  if (options.stenosis_percent > 0.0) {
    main.lesions = {
        lesion_at(lesion_center, lesion_radius, options, {0.0, 1.0, 0.0}, LesionShape::eccentric)};
    sites = {{0, lesion_center, main.lesions[0].length_mm}};
  }
  std::vector<Branch> branches{sample_vessel(main)};
  branches.push_back(leave(branches, 0, main, first_fork,
                           {42.0 * k,
                            2.5 * radius,
                            lad_lcx.smaller,
                            0.68 * lad_lcx.smaller,
                            {{3.2 * radius, {0.68, 0.55, -0.48}},
                             {16.0 * k, {0.30, 0.85, -0.43}},
                             {28.0 * k, {-0.08, 0.80, -0.60}},
                             {42.0 * k, {-0.25, 0.45, -0.86}}}}));
  branches.push_back(leave(branches, 0, main, second_fork,
                           {26.0 * k,
                            2.5 * radius,
                            lad_diagonal.smaller,
                            0.75 * lad_diagonal.smaller,
                            {{2.8 * radius, {0.88, -0.08, -0.47}},
                             {15.0 * k, {0.72, 0.22, -0.66}},
                             {26.0 * k, {0.40, 0.42, -0.82}}}}));
  return {LumenShape(std::move(branches)), sites};
}

}  // namespace

const DefaultSize& default_size(std::string_view name) {
  std::vector<std::string> names;
  for (const DefaultSize& size : kDefaultSizes) {
    if (size.name == name) return size;
    names.emplace_back(size.name);
  }
  std::string all;
  for (const std::string& known : names) all += (all.empty() ? "" : ", ") + known;
  throw OptionError("no phantom is called \"" + std::string(name) + "\" (there are: " + all +
                    "). Did you mean \"" + nearest_name(name, names) + "\"?");
}

PhantomOptions with_size(const PhantomOptions& options) {
  options.validate();
  PhantomOptions sized = options;
  const DefaultSize& size = default_size(options.name);
  if (sized.length_mm <= 0.0) {
    // A wider vessel alone is also longer, so that its shape stays.
    const double scale = sized.radius_mm > 0.0 && size.radius_mm > 0.0
                             ? std::max(1.0, sized.radius_mm / size.radius_mm)
                             : 1.0;
    sized.length_mm = scale * size.length_mm;
  }
  if (sized.radius_mm <= 0.0)
    sized.radius_mm =
        std::min(size.radius_mm, sized.length_mm / std::max(size.least_length_in_radii, 1.0));
  return sized;
}

Anatomy make_anatomy(const PhantomOptions& options) {
  const PhantomOptions sized = with_size(options);
  if (sized.name == "ytype") return make_fork(sized, 2);
  if (sized.name == "trifurcation") return make_fork(sized, 3);
  if (sized.name == "coronary") return make_coronary(sized);
  if (sized.name == "aneurysm") return make_aneurysm(sized);
  if (sized.name == "tandem") return make_tandem(sized);
  if (sized.name == "helix") return make_helix(sized);
  if (sized.name == "torus") return make_torus(sized);
  return make_tube(sized);
}

}  // namespace angio::datasets::detail

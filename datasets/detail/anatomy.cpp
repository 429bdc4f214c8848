#include "datasets/detail/anatomy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"
#include "datasets/detail/nearest_name.hpp"
#include "datasets/detail/vessel_plan.hpp"

namespace angio::datasets::detail {
namespace {

constexpr double kLesionLengthInRadii = 6.0;

/// Sizes: large epicardial arteries (straight, unilateral, bilateral, ytype); left main, LAD, LCx
/// and diagonal after Dodge et al., Circulation 86:232, 1992 (left main 4.5 mm, proximal LAD 3.7
/// mm).
constexpr std::array<DefaultSize, 6> kDefaultSizes{{
    {"straight", 1.5, 40.0, 4.0},
    {"unilateral", 1.5, 40.0, 9.0},
    {"bilateral", 1.5, 40.0, 9.0},
    {"ytype", 1.8, 45.0, 18.0},
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

Anatomy make_tube(const PhantomOptions& options) {
  VesselPlan plan = straight_plan(options);
  std::optional<LesionSite> site;
  if (options.name != "straight" && options.stenosis_percent > 0.0) {
    const LesionShape shape =
        options.name == "bilateral" ? LesionShape::two_sided : LesionShape::eccentric;
    plan.lesion =
        lesion_at(0.5 * plan.length_mm, options.radius_mm, options, {1.0, 0.0, 0.0}, shape);
    site = LesionSite{0, plan.lesion->center_mm, plan.lesion->length_mm};
  }
  return {LumenShape({sample_vessel(plan)}), site};
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

/// A Y in the x-z plane: the parent runs down, the daughters part by 35 degrees each, the stenosis
/// begins on the outer wall of one of them just past the carina.
Anatomy make_ytype(const PhantomOptions& options) {
  const double radius = options.radius_mm;
  const double trunk = 0.35 * options.length_mm;
  const double daughter_length = options.length_mm - trunk;
  const double daughter_radius = divide_by_murray(radius, 1.0).larger;
  const double turn = 3.0 * radius;
  const double angle = 35.0 * units::kPi / 180.0;
  const Vec3 down{0.0, 0.0, -1.0};
  const Vec3 left{std::sin(angle), 0.0, -std::cos(angle)};
  const Vec3 right{-left.x, 0.0, left.z};

  VesselPlan main = straight_plan(options);
  main.directions = {{trunk, down}, {trunk + turn, left}};
  main.radii = {{0.0, trunk, radius, radius, 0.0},
                {trunk, options.length_mm, daughter_radius, daughter_radius, turn}};
  const SideBranch side{daughter_length, turn, daughter_radius, daughter_radius, {{turn, right}}};
  const auto grow = [&] {
    std::vector<Branch> branches{sample_vessel(main)};
    branches.push_back(leave(branches, 0, main, trunk, side));
    return branches;
  };
  const std::vector<Branch> healthy = grow();
  if (options.stenosis_percent <= 0.0) return {LumenShape(healthy), std::nullopt};

  const double lesion_length = kLesionLengthInRadii * daughter_radius;
  const double center = separation_mm(healthy[0], healthy[1]) + 0.5 * lesion_length;
  main.lesion =
      lesion_at(center, daughter_radius, options, {-1.0, 0.0, 0.0}, LesionShape::eccentric);
  return {LumenShape(grow()), LesionSite{0, center, lesion_length}};
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
  std::optional<LesionSite> site;
  if (options.stenosis_percent > 0.0) {
    main.lesion =
        lesion_at(lesion_center, lesion_radius, options, {0.0, 1.0, 0.0}, LesionShape::eccentric);
    site = LesionSite{0, lesion_center, main.lesion->length_mm};
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
  return {LumenShape(std::move(branches)), site};
}

}  // namespace

const DefaultSize& default_size(std::string_view name) {
  std::vector<std::string_view> names;
  for (const DefaultSize& size : kDefaultSizes) {
    if (size.name == name) return size;
    names.push_back(size.name);
  }
  std::string all;
  for (std::string_view known : names) all += (all.empty() ? "" : ", ") + std::string(known);
  throw OptionError("no phantom is called \"" + std::string(name) + "\" (there are: " + all +
                    "). Did you mean \"" + std::string(nearest_name(name, names)) + "\"?");
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
  if (sized.name == "ytype") return make_ytype(sized);
  if (sized.name == "coronary") return make_coronary(sized);
  return make_tube(sized);
}

}  // namespace angio::datasets::detail

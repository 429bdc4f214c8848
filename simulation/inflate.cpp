#include "simulation/inflate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "core/error.hpp"
#include "core/require.hpp"
#include "core/units.hpp"
#include "simulation/newton/inflation_curve.hpp"

namespace angio::simulation {
namespace {

using namespace detail;

// The balloon's enclosed volume over that of what is meshed, unloaded: facets lie around the
// circle, and a piece of tube is short.
double smooth_volume(const FreeBalloon& balloon, const Capsule& capsule) {
  const double r = balloon.radius_mm;
  const double caps = balloon.ends == BalloonEnds::hemispheres ? 4.0 / 3.0 * r : 0.0;
  return units::kPi * r * r * (balloon.length_mm + caps) / enclosed_volume(capsule.mesh);
}

double mean_z(const Capsule& capsule, const std::vector<Vec3>& x, int ring) {
  double sum = 0.0;
  for (int k = 0; k < capsule.around; ++k) sum += x[std::size_t(ring * capsule.around + k)].z;
  return sum / capsule.around;
}

// Of the middle ring's vertices from their centre.
double mean_radius(const Capsule& capsule, const std::vector<Vec3>& x) {
  const auto ring = x.begin() + std::ptrdiff_t(capsule.middle_ring) * capsule.around;
  Vec3 centre;
  double sum = 0.0;
  for (int k = 0; k < capsule.around; ++k) centre += (1.0 / capsule.around) * ring[k];
  for (int k = 0; k < capsule.around; ++k) sum += distance(ring[k], centre);
  return sum / capsule.around;
}

// Thickness and stress of the triangles on both sides of the middle ring, by area.
void measure_membrane(const Capsule& capsule, const MembraneTerm& membrane,
                      const std::vector<Vec3>& x, double wall, InflationPoint& point) {
  double whole = 0.0, thickness = 0.0, stress = 0.0;
  const int first = capsule.middle_ring * capsule.around, last = first + capsule.around;
  for (std::size_t t = 0; t < capsule.membrane.size(); ++t) {
    const Triangle& corner = capsule.membrane[t];
    if (std::none_of(corner.begin(), corner.end(), [&](int v) { return v >= first && v < last; }))
      continue;
    const Vec3& a = x[std::size_t(corner[0])];
    const double area = norm(cross(x[std::size_t(corner[1])] - a, x[std::size_t(corner[2])] - a));
    const MembraneStress<double> here = membrane.stress(t, x);
    whole += area;
    thickness += area * wall * here.thickness_ratio;
    stress += area * here.stress[0];
  }
  point.wall_mm = thickness / whole;
  point.stress_mpa = stress / whole / units::kPascalPerMegapascal;
}

InflationPoint measure(const FreeBalloon& balloon, const Capsule& capsule, const FreeState& state) {
  const double lengths = balloon.length_mm / capsule.length;
  const MembraneTerm membrane = membrane_of(balloon, capsule);
  InflationPoint point;
  point.pressure_atm = units::atm_from_pascal(state.pressure);
  point.volume_mm3 = smooth_volume(balloon, capsule) * state.volume;
  point.energy_mj = 1e-6 * lengths * membrane.value(state.x);
  point.residual = state.residual;
  point.converged = state.converged;
  point.length_mm = lengths * (mean_z(capsule, state.x, capsule.last_ring) -
                               mean_z(capsule, state.x, capsule.first_ring));
  point.diameter_mm = 2.0 * mean_radius(capsule, state.x) / capsule.circle_factor;
  measure_membrane(capsule, membrane, state.x, balloon.material.wall_mm, point);
  return point;
}

void check_volumes(const std::vector<double>& volumes, double unloaded) {
  for (const double v : volumes) {
    if (v >= unloaded * (1.0 - 1e-9)) continue;
    char text[250];
    std::snprintf(text, sizeof text,
                  "a volume of %g mm3 is asked for (the balloon encloses %g mm3 unloaded; below "
                  "that its thin wall collapses in folds). Ask for more",
                  v, unloaded);
    throw InputError(text, ExitCode::usage);
  }
}

void check_solver(const FreeBalloon& balloon, const InflateOptions& options) {
  if (options.solver == InflateSolver::newton) return;
  if (balloon.ends != BalloonEnds::hemispheres)
    throw OptionError(
        "a piece of a tube is asked for (only the solver newton knows how its ends move). Use "
        "newton, or hemispherical ends");
  if (options.solver == InflateSolver::paper && !options.volumes_mm3.empty())
    throw OptionError(
        "the solver paper is asked to hold a volume (it takes pressures only). Use vbd or newton");
  if (options.solver == InflateSolver::paper && !balloon.material.chart.empty())
    throw OptionError(
        "the solver paper is asked to follow a chart (it knows no fibres). Use vbd or newton");
}

}  // namespace

double InflateOptions::tolerance_in_force() const {
  if (tolerance > 0.0) return tolerance;
  return solver == InflateSolver::newton ? 1e-8 : 1e-4;
}

void FreeBalloon::validate() const {
  require_within("balloon.radius_mm", radius_mm, 0.1, 50.0);
  require_within("balloon.length_mm", length_mm, 0.5, 500.0);
  SimulationOptions options;
  options.balloon = material;
  options.validate();
  if (material.chart.empty()) return;
  const double charted = 0.5 * rest_diameter_mm(material.chart);
  require_within("balloon.radius_mm (of the chart)", radius_mm, 0.999 * charted, 1.001 * charted);
}

void InflateOptions::validate() const {
  if (pressures_atm.empty() == volumes_mm3.empty())
    throw OptionError("inflate.pressures and inflate.volumes are " +
                      std::string(volumes_mm3.empty() ? "both missing" : "both given") +
                      " (the balloon is held at one or the other). Give one of them");
  for (const double p : pressures_atm) require_within("inflate.pressures", p, 0.0, 100.0);
  for (const double v : volumes_mm3) require_within("inflate.volumes", v, 0.0, 1e7);
  require_within("inflate.around", around, 8.0, 256.0);
  if (around % 4 != 0)
    throw OptionError("inflate.around is " + std::to_string(around) +
                      " (it must be a multiple of 4)");
  require_within("inflate.tolerance", tolerance, 0.0, 1e-2);
}

FreeBalloon free_balloon(const CatalogueBalloon& balloon) {
  balloon.validate();
  FreeBalloon free;
  free.radius_mm = 0.5 * rest_diameter_mm(balloon);
  free.length_mm = balloon.length_mm;
  free.material.name = balloon.material;
  free.material.wall_mm = balloon.wall_mm;
  free.material.chart = balloon.chart;
  return free;
}

std::vector<InflationPoint> inflate(const FreeBalloon& balloon, const InflateOptions& options,
                                    const Progress& progress) {
  balloon.validate();
  options.validate();
  check_solver(balloon, options);
  const Capsule capsule = mesh_of(balloon, options.around);
  const double smooth = smooth_volume(balloon, capsule);
  check_volumes(options.volumes_mm3, smooth * enclosed_volume(capsule.mesh));
  const Hold hold = options.volumes_mm3.empty() ? Hold::pressure : Hold::volume;
  std::vector<double> asked;
  for (const double v : options.volumes_mm3) asked.push_back(v / smooth);
  for (const double p : options.pressures_atm) asked.push_back(units::pascal_from_atm(p));
  std::vector<std::size_t> order(asked.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return asked[a] < asked[b]; });
  std::vector<double> rising;
  for (const std::size_t i : order) rising.push_back(asked[i]);
  const auto states = find_states(balloon, capsule, options, hold, rising, progress);
  std::vector<InflationPoint> points(asked.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    points[order[i]] = measure(balloon, capsule, states[i]);
  return points;
}

}  // namespace angio::simulation

#include "simulation/run/control.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "simulation/backends/state.hpp"
#include "simulation/pbd/policy.hpp"

namespace angio::simulation::detail {
namespace {

constexpr double kTaperInRadii = 4.0;

}  // namespace

double expected_volume(const SimulationModel& model, const Scene& scene, double start_volume) {
  TriangleMesh rest = model.balloon;
  rest.vertices = model.balloon_rest;
  const double rest_volume = enclosed_volume(rest);
  if (scene.balloon.membrane.relaxed || scene.bodies.wall().count == 0)
    return std::max(rest_volume, start_volume);
  const double radius = 2.0 * start_volume / surface_area(model.balloon);  // a tube's
  const double length = start_volume / (units::kPi * radius * radius);
  const double full = std::max(radius, model.reference_radius_mm);
  const double taper = std::min(0.5 * length, kTaperInRadii * full);
  return std::max(start_volume, units::kPi * full * full * (length - 2.0 / 3.0 * taper));
}

StepRules make_rules(const Scene& scene, const SimulationOptions& options) {
  constexpr int kMostSweeps = 120;
  constexpr int kMostFactor = 6;  // up to this many times the number asked for
  constexpr int kLastFactor = 24;
  constexpr int kSlackSweeps = 8;
  constexpr double kLeastShare = 0.25;  // of the rest radius: none is more exact for a slim start
  StepRules rules;
  rules.least_sweeps = options.sweeps;
  rules.most_sweeps = options.sweeps > 0 ? kMostFactor * options.sweeps : kMostSweeps;
  const PbdPolicy pbd = pbd_policy(options);
  if (!pbd.balances())
    rules.least_sweeps = rules.most_sweeps = options.sweeps > 0 ? options.sweeps : kPbdSweeps;
  rules.later_sweeps = rules.most_sweeps / 2;
  rules.slack_sweeps = std::max(kSlackSweeps, rules.least_sweeps);
  if ((scene.bodies.wall().count > 0 || scene.rod.count > 0) &&
      rules.least_sweeps < rules.most_sweeps)
    rules.last_sweeps = kLastFactor * rules.most_sweeps;
  rules.still = !pbd.goes_on();
  rules.tolerance = options.tolerance;
  // Of a cylinder of the balloon's volume and length.
  double length = 0.0;
  for (std::size_t v = 0; v < std::size_t(scene.bodies.balloon().count); ++v)
    length = std::max(length, norm(scene.start[v] - scene.origin));
  const double volume = balloon_volume(scene, scene.start);
  rules.radius = std::max(std::sqrt(volume / (units::kPi * 2.0 * length)),
                          kLeastShare * scene.balloon.rest_radius);
  rules.least_load = 0.1 * units::pascal_from_atm(options.inflation.peak_pressure_atm);
  return rules;
}

StepRules settling_rules(const Scene& scene, const SimulationOptions& options, double tolerance,
                         int most_sweeps) {
  StepRules rules = make_rules(scene, options);
  rules.tolerance = rules.residual = tolerance;
  rules.rest = 0.0;
  rules.most_sweeps = rules.later_sweeps = rules.slack_sweeps = most_sweeps;
  rules.still = true;
  return rules;
}

Control make_control(const Scene& scene, const SimulationOptions& options, double nominal_volume) {
  return {Inflator(options, balloon_volume(scene, scene.start), nominal_volume),
          make_rules(scene, options)};
}

}  // namespace angio::simulation::detail

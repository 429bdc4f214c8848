#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/pbd/tets.hpp"
#include "simulation/step/near_pairs.hpp"

namespace angio::simulation::detail {

Precision precision_for(const Scene& scene, const SimulationOptions& options) {
  if (scene.wall.solid.levels > 0) return Precision::double_;  // thin, nearly incompressible layers
  // Its tets do not settle: what one rounding changes is a millionfold larger at the end.
  if (options.gas_model == GasModel::per_tet) return Precision::double_;
  double extent = 0.0, edge = 0.0;
  for (int v = 0; v < scene.bodies.balloon().count; ++v)
    extent = std::max(extent, norm(scene.start[std::size_t(v)] - scene.origin));
  for (const Edge& e : scene.balloon.edges)
    edge += distance(scene.start[std::size_t(e[0])], scene.start[std::size_t(e[1])]);
  edge /= double(scene.balloon.edges.size());
  // Bounds of motion leave the least gap: it must stand out from the spacing of positions.
  constexpr double kSpacingsInLeastGap = 40.0;
  double far = 0.0;
  for (const Vec3& p : scene.start) far = std::max(far, norm(p - scene.origin));
  const double spacing = double(std::numeric_limits<float>::epsilon()) * far;
  if (scene.bodies.wall().count > 0 &&
      kSpacingsInLeastGap * spacing > kLeastGap * options.contact.distance_mm)
    return Precision::double_;
  // On a vertex: the membrane's force for a strain s is about E h s edge, the load p edge^2, E = 6
  // (C1
  // + C2); rounding errors of half a spacing in six triangles largely cancel.
  const double strain = 0.25 * double(std::numeric_limits<float>::epsilon()) * extent / edge;
  const double stiffness = 6.0 * (scene.balloon.membrane.base.c1 + scene.balloon.membrane.base.c2) *
                           scene.balloon.thickness;
  const double load = units::pascal_from_atm(options.inflation.peak_pressure_atm) * edge;
  return stiffness * strain < 0.5 * StepRules{}.residual * load ? Precision::single
                                                                : Precision::double_;
}

StepRules make_rules(const Scene& scene, const SimulationOptions& options) {
  constexpr int kMostSweeps = 120;
  constexpr int kPbdSweeps = 20;  // what is projected never balances: a count, no tolerance
  constexpr int kMostFactor = 6;  // up to this many times the number asked for
  constexpr int kLastFactor = 24;
  constexpr double kLeastShare = 0.25;  // of the rest radius: none is more exact for a slim start
  StepRules rules;
  rules.least_sweeps = options.sweeps;
  rules.most_sweeps = options.sweeps > 0 ? kMostFactor * options.sweeps : kMostSweeps;
  if (projects(options))
    rules.least_sweeps = rules.most_sweeps = options.sweeps > 0 ? options.sweeps : kPbdSweeps;
  rules.later_sweeps = rules.most_sweeps / 2;
  if ((scene.bodies.wall().count > 0 || scene.rod.count > 0) &&
      rules.least_sweeps < rules.most_sweeps)
    rules.last_sweeps = kLastFactor * rules.most_sweeps;
  rules.still = options.gas_model == GasModel::per_tet;
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

}  // namespace angio::simulation::detail

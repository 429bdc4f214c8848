#include <cmath>
#include <limits>

#include "core/units.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/pbd/policy.hpp"
#include "simulation/step/near_pairs.hpp"

namespace angio::simulation::detail {

Precision precision_for(const Scene& scene, const SimulationOptions& options) {
  if (scene.wall.solid.levels > 0) return Precision::double_;  // thin, nearly incompressible layers
  if (pbd_policy(options).needs_double()) return Precision::double_;
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

}  // namespace angio::simulation::detail

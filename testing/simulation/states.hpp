#pragma once

#include <vector>

#include "simulation/backends/step_solver.hpp"

namespace angio::simulation::testing {

/// Every state of a run.
///
/// @param growth  nominal volume over the start shape's
inline std::vector<detail::State> states_of(detail::StepSolver& solver, const detail::Scene& scene,
                                            const SimulationOptions& options, double growth = 1.3) {
  const double volume = detail::balloon_volume(scene, scene.start);
  std::vector<detail::State> states;
  solver.run(detail::make_control(scene, options, growth * volume),
             [&](int, const detail::State& state) { states.push_back(state); });
  return states;
}

}  // namespace angio::simulation::testing

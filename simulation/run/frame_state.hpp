#pragma once

#include "simulation/backends/state.hpp"
#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

/// Completes a frame with what a step has left: shapes in the caller's numbering, fields, measures;
/// all but its number, time, phase and air.
/// @param outside  absolute pressure around the balloon [Pa]
void add_state(const SimulationModel& model, const std::shared_ptr<const Scene>& scene,
               const std::shared_ptr<const State>& state, double outside, SimulationFrame& frame);

}  // namespace angio::simulation::detail

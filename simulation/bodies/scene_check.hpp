#pragma once

#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

/// Refuses a model that cannot be simulated, with the element that is wrong and what to do: arrays
/// that do not match, positions that are no numbers, corners that do not exist, vertices on one
/// another or in no triangle, triangles without area; a balloon that is open, in pieces or inside
/// out, or whose guidewire lies outside it; a wall in pieces or held by nothing.
///
/// @throws InputError
void check_model(const SimulationModel& model, const WallMaterial& wall);

}  // namespace angio::simulation::detail

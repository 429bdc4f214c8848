#pragma once

#include <nlohmann/json.hpp>

#include "pipeline/case/stage_files.hpp"
#include "pipeline/stages/stage_settings.hpp"
#include "simulation/simulation.hpp"

namespace angio::pipeline {

/// The solver's model from the files of the stages before.
/// @param placement  placement.json of a case with a balloon
simulation::SimulationModel load_simulation_model(const StageFiles& files,
                                                  const nlohmann::json& placement);

/// The solver's options for that balloon.
simulation::SimulationOptions load_simulation_options(const SimulationSettings& settings,
                                                      const nlohmann::json& placement);

}  // namespace angio::pipeline

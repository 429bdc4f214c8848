#pragma once

#include <string>

#include "core/triangle_mesh.hpp"
#include "pipeline/config/config.hpp"
#include "pipeline/stages/stage_work.hpp"

/// The seed paper's experiments, which begin with an exact mesh instead of a scan. Which of them
/// is run is the setting input.experiment; presets.cpp has the rest.
namespace angio::pipeline {

/// Whether the case is the cloth, which is no vessel.
bool is_cloth(const Config& config);

/// What the program takes where no INPUT is given; empty if the run is no experiment.
std::string default_input(const Config& config);

/// @throws Error (64) if INPUT is no mesh of the experiment's
void check_experiment_input(const Config& config, const std::string& input);

/// The lumen surface that an experiment begins with. `input` names a phantom.
TriangleMesh experiment_surface(StageWork& work);

}  // namespace angio::pipeline

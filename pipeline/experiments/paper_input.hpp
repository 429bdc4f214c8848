#pragma once

#include <string>

#include "pipeline/config/config.hpp"

/// INPUT of the seed paper's experiments, which begin with an exact mesh instead of a scan. Which
/// of them is run is the setting input.experiment; presets.cpp has the rest.
namespace angio::pipeline {

/// What the program takes where no INPUT is given; empty if the run is no experiment.
std::string default_input(const Config& config);

/// @throws Error (64) if INPUT is no mesh of the experiment's
void check_experiment_input(const Config& config, const std::string& input);

}  // namespace angio::pipeline

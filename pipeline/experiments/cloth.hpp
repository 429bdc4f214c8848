#pragma once

#include "pipeline/config/config_view.hpp"
#include "pipeline/stages/stage_definition.hpp"

/// The seed paper's cloth (section 6.1, Figure 5), which is no vessel: it has a mesh, a pull and a
/// report, in the folders of those stages.
namespace angio::pipeline {

inline constexpr const char* kClothExperiment = "cloth";

/// What each of its stages sees of the configuration.
using ClothSettings = ConfigView<&Config::experiment, &Config::cloth>;

const Workflow& cloth_workflow();

}  // namespace angio::pipeline

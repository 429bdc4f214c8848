#pragma once

#include "pipeline/stages/stage_definition.hpp"

namespace angio::pipeline {

/// The stages that a configuration asks for: those of a vessel, or those of the paper's cloth.
const Workflow& workflow_of(const Config& config);

}  // namespace angio::pipeline

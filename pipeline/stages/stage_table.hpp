#pragma once

#include "pipeline/stages/stage_definition.hpp"

namespace angio::pipeline {

/// The stages of a vessel.
const Workflow& vessel_workflow();

}  // namespace angio::pipeline

#include "pipeline/experiments/workflow.hpp"

#include "pipeline/experiments/cloth.hpp"
#include "pipeline/stages/stage_table.hpp"

namespace angio::pipeline {

const Workflow& workflow_of(const Config& config) {
  return config.experiment == kClothExperiment ? cloth_workflow() : vessel_workflow();
}

}  // namespace angio::pipeline

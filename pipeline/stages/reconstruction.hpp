#pragma once

#include "pipeline/stages/stage_settings.hpp"
#include "pipeline/stages/stage_work.hpp"

namespace angio::pipeline {

/// From the frames of a rotational run to a volume.
void do_reconstruction(StageWork& work, const ReconstructionSettings& settings);

}  // namespace angio::pipeline

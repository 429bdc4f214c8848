#pragma once

#include "pipeline/stages/stage_settings.hpp"
#include "pipeline/stages/stage_work.hpp"
#include "segmentation/read_views.hpp"

namespace angio::pipeline {

/// From angiograms of a C-arm that stood still to a volume: the reconstruction of such an input.
void do_views(StageWork& work, const segmentation::LoadedViews& loaded,
              const ReconstructionSettings& settings);

}  // namespace angio::pipeline

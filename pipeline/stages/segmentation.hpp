#pragma once

#include "pipeline/stages/stage_settings.hpp"
#include "pipeline/stages/stage_work.hpp"

namespace angio::pipeline {

/// The work of the stage segmentation: reads the case's files, calls the stage's verb, writes its
/// files.
void do_segmentation(StageWork& work, const SegmentationSettings& settings);

}  // namespace angio::pipeline

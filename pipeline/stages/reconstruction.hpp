#pragma once

#include <vector>

#include "angiogram/cone_beam.hpp"
#include "pipeline/stages/stage_settings.hpp"
#include "pipeline/stages/stage_work.hpp"
#include "segmentation/read_run.hpp"

namespace angio::pipeline {

/// From the frames of a rotational run to a volume.
void do_reconstruction(StageWork& work, const ReconstructionSettings& settings);

/// The frames of a run where its header says that they were taken.
std::vector<angiogram::ConeBeamFrame> frames_by_header(const segmentation::LoadedRun& loaded);

/// @return [s]
std::vector<double> in_seconds(std::vector<double> times_ms);

}  // namespace angio::pipeline

#pragma once

#include "pipeline/stages/stage_settings.hpp"
#include "pipeline/stages/stage_work.hpp"

namespace angio::pipeline {

/// The work of the stage report: reads the case's files, calls the stage's verb, writes its files.
void do_report(StageWork& work, const ReportSettings& settings);

}  // namespace angio::pipeline

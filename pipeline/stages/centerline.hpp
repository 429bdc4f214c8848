#pragma once

#include "pipeline/stages/stage_settings.hpp"
#include "pipeline/stages/stage_work.hpp"

namespace angio::pipeline {

/// The place of the lesion is withheld unless the vessel is to be narrowed there.
CenterlineSettings centerline_settings(const Config& config);

/// The work of the stage centerline: reads the case's files, calls the stage's verb, writes its
/// files.
void do_centerline(StageWork& work, const CenterlineSettings& settings);

}  // namespace angio::pipeline

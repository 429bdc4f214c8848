#pragma once

#include <vector>

#include "pipeline/case/stage_files.hpp"
#include "pipeline/case/working_view.hpp"
#include "viewer/report.hpp"

namespace angio::pipeline {

/// The case as a C-arm sees it in its best view and in the second one: each before and, if it was
/// simulated, after, in turn. The pictures are around the lesion, so wide that they hold what was
/// measured along the treated line.
/// @param content  with lumen, tree, lesion and profiles
viewer::CArmViews carm_views(const StageFiles& files, const CaseWorkingView& view,
                             const viewer::ReportContent& content);

/// Some frames of the rotational run that the case was reconstructed from; none of other cases.
/// @throws InputError  its files do not belong together
std::vector<viewer::XrayPicture> xray_frames(const StageFiles& files);

}  // namespace angio::pipeline

#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "angiogram/working_view.hpp"
#include "pipeline/case/case_folder.hpp"
#include "pipeline/case/stage_files.hpp"

namespace angio::pipeline {

struct CaseWorkingView {
  nlohmann::json metrics;                      ///< `working_view` of metrics.json
  std::optional<angiogram::WorkingView> view;  ///< unset: there is no place to look at
};

/// What case_working_view() reads.
std::vector<std::string> working_view_files();

/// `working_view` of metrics.json, all null. @param reason  why
nlohmann::json no_working_view(const std::string& reason = {});

/// The C-arm's best view of the case's lesion, between its edges; where it has none, of one
/// reference diameter to both sides of the narrowest place.
///
/// The angles are the patient's only where the input says how it lies in the patient; a surface,
/// and a volume that names no patient space, do not (`patient_axes` is "assumed").
CaseWorkingView case_working_view(const StageFiles& files,
                                  const angiogram::WorkingViewOptions& options,
                                  const RunRecord& record);

}  // namespace angio::pipeline

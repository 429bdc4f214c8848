#pragma once

#include <string>

#include "pipeline/case/case_folder.hpp"
#include "pipeline/case/stage_files.hpp"

namespace angio::pipeline {

/// How a case stands: metrics.json's status and status_reason.
struct CaseStatus {
  /// "done": a stenosis was treated; "no_lesion": there was none to treat; "not_determined": there
  /// is one that could not be, or two runs of its treatment disagree;
  /// "failed": a stage, or its result, was not right; "stale": a stage's settings or inputs have
  /// changed, and it was not run again. Empty: stages are still to be run.
  std::string status;
  std::string reason;  ///< a sentence; empty when done

  /// May numbers of a treatment be told?
  [[nodiscard]] bool has_result() const { return status == "done" || status == "no_lesion"; }
};

/// @param files  with meshing/placement.json and simulation/summary.json
CaseStatus case_status(const StageFiles& files, const RunRecord& record);

/// Has the stage meshing found no place for a balloon? Then there is nothing to simulate.
bool is_untreated(const CaseFolder& case_folder);

/// What brings a balloon to where none was placed.
inline constexpr const char* kToTreatAnyway =
    "another place (--set lesion.centerline=N lesion.abscissa_mm=S), a balloon of your own (--set "
    "balloon.nominal_diameter_mm=D balloon.length_mm=L), or more of the vessel in the input";

/// @throws InputError with the reason, where a case has nothing to simulate
void refuse_untreated(const CaseFolder& case_folder);

}  // namespace angio::pipeline

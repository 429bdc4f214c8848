#pragma once

#include <string>

#include "pipeline/case/case_folder.hpp"
#include "pipeline/stages/run_case.hpp"
#include "pipeline/stages/stage_definition.hpp"

namespace angio::pipeline {

/// Is INPUT, as far as its name tells, DICOM?
bool is_dicom(const std::string& input);

/// Is the stage one for the case's kind of input?
bool applies(const StageDefinition& stage, const RunRecord& record);

/// The same of the one volume or surface in a folder that holds no DICOM.
/// @throws InputError (65) if there are several, or the folder is a case's
RunRequest with_file_of_folder(RunRequest request);

/// A new record of what a request names as its input; the case's own record where it names none.
/// @throws InputError (66) if there is neither
RunRecord describe_input(const RunRequest& request, const CaseFolder& folder);

/// How far a case has come with what a request asks for.
struct CaseProgress {
  enum class State {
    not_begun,
    of_another,  ///< the folder is another case's, or no case's: a run is refused
                 ///< without --force
    begun,
    done,
  };
  State state = State::not_begun;
  std::string next;         ///< the stage that would be run next, and why; empty unless it is begun
  bool is_minimal = false;  ///< done, and its bulky files were removed
};

/// Judges a case by its present files, its very input and configuration. Nothing is written.
CaseProgress case_progress(const Workflow& workflow, const RunRequest& request);

}  // namespace angio::pipeline

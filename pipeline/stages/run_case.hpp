#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pipeline/case/case_folder.hpp"
#include "pipeline/config/config.hpp"
#include "pipeline/stages/reporter.hpp"
#include "pipeline/stages/stage_definition.hpp"

namespace angio::pipeline {

/// One call of `angio run`, or of a single stage on a case that exists.
struct RunRequest {
  std::string input;  ///< path or "phantom:..."; empty: the case's own
  std::filesystem::path case_folder;
  std::string case_name;  ///< empty: the first digits of the input's hash
  Config config;
  std::optional<Stage> from;  ///< this stage and those after it run again
  Stage until = Stage::report;
  bool force = false;      ///< run everything again, into any folder
  bool keep_link = false;  ///< write source.private.json and, of DICOM, segmentation.private.dcm
};

/// Runs the stages whose inputs or options have changed, in order, and keeps run.json and
/// metrics.json up to date after each.
/// @return the report, or the folder of the last stage that was asked for
std::filesystem::path run_case(const Workflow& workflow, const RunRequest& request,
                               Reporter& reporter);

/// How far a case has come with what a request asks for.
struct CaseProgress {
  enum class State {
    not_begun,
    of_another,  ///< the folder is another case's, or no case's: a run is refused
    begun,
    done,
  };
  State state = State::not_begun;
  std::string next;  ///< the stage that would be run next, and why; empty unless it is begun
};

/// Judges a case by its present files, its very input and configuration. Nothing is written.
CaseProgress case_progress(const Workflow& workflow, const RunRequest& request);

/// The configuration that a case was last run with.
/// @throws InputError (66) if the folder is no case
Config case_config(const CaseFolder& case_folder);

}  // namespace angio::pipeline

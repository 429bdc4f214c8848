#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pipeline/case/case_folder.hpp"
#include "pipeline/config/config.hpp"
#include "pipeline/stages/minimal_case.hpp"
#include "pipeline/stages/reporter.hpp"
#include "pipeline/stages/stage_definition.hpp"

namespace angio::pipeline {

/// One call of `angio run`, or of a single stage on a case that exists.
struct RunRequest {
  std::string input;               ///< path or "phantom:..."; empty: the case's own
  std::string source;              ///< what `keep_link` keeps, if it is not INPUT's path
  std::filesystem::path geometry;  ///< a file that says where INPUT's X-ray frames were taken
  std::filesystem::path case_folder;
  std::string case_name;  ///< empty: the first digits of the input's hash
  Config config;
  std::optional<Stage> from;  ///< this stage and those after it run again
  Stage until = Stage::report;
  bool force = false;      ///< run everything again, into any folder
  Keep keep = Keep::all;   ///< when the report is made, too; not of a run that ends before it
  bool keep_link = false;  ///< write source.private.json and, of DICOM, segmentation.private.dcm
};

/// Runs the stages whose inputs or options have changed, in order, and keeps run.json and
/// metrics.json up to date after each.
/// @return the report, or the folder of the last stage that was asked for
std::filesystem::path run_case(const Workflow& workflow, const RunRequest& request,
                               Reporter& reporter);

/// The configuration that a case was last run with.
/// @throws InputError (66) if the folder is no case
Config case_config(const CaseFolder& case_folder);

}  // namespace angio::pipeline

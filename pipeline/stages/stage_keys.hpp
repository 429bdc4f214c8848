#pragma once

#include <map>
#include <string>

#include "pipeline/case/case_folder.hpp"
#include "pipeline/stages/stage_definition.hpp"

/// When a stage's result is of another state of the case than the one that is asked for.
namespace angio::pipeline {

/// The SHA-256 of all that a stage's work sees: version, settings, the run, the files it reads.
/// @param inputs  file in the case -> SHA-256
std::string stage_key(const StageDefinition& stage, const Config& config, const RunRecord& run,
                      const std::map<std::string, std::string>& inputs);

/// The same by the hashes that the stages before have recorded; no file is read.
std::string recorded_key(const StageDefinition& stage, const Config& config, const RunRecord& run);

/// Marks every stage stale, or as no longer so, by what run.json holds: a stage is stale if its key
/// would be another one now, if a file that it left is missing, or if a stage before it is stale.
/// Files are not read: that they are as they were left is found out when the stage's turn comes.
void mark_stale(const CaseFolder& case_folder, const Workflow& workflow, const Config& config,
                RunRecord& run);

/// The SHA-256 of the case's report without the notice that mark_report() puts into it.
std::string report_hash(const CaseFolder& case_folder);

/// Says at the head of the case's report that it is stale, or no longer says so.
void mark_report(const CaseFolder& case_folder, bool is_stale);

}  // namespace angio::pipeline

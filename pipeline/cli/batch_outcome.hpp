#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cli/manifest.hpp"

/// How the cases of a batch have ended, in files: logs/CASE.json for each, and the summary of all.
namespace angio::pipeline {

struct Outcome {
  /// "done", "failed", "interrupted", "started" (and not ended, or killed), "stale" (its row has
  /// changed since), "not run"
  std::string status = "not run";
  int exit_code = -1;  ///< -1: none
  int tries = 0;
  std::string reason;  ///< the last line that the case printed
};

/// Writes logs/CASE.json: the outcome, and the row that it is of; and logs/CASE.done, an empty file
/// that is there if and only if the case is done.
void write_outcome(const std::filesystem::path& folder, const BatchCase& batch_case,
                   const Outcome& outcome);

/// logs/CASE.done, of a case that was found to be done.
void mark_done(const std::filesystem::path& folder, const BatchCase& batch_case);

/// Whether this batch has run the row to its end before: its folder is the batch's own.
bool was_done(const std::filesystem::path& folder, const BatchCase& batch_case);

/// By logs/CASE.json, or by the case's own files where there is none.
Outcome last_outcome(const std::filesystem::path& folder, const BatchCase& batch_case);

/// Writes `file`, a row a case with the numbers of those done, and beside it the same with times,
/// memory and remarks as .json, and as a page (.html). The whole batch's also has a page of
/// pictures, sheet.html, and how the cases are spread as figures/MEASURE.svg.
void write_summary(const std::filesystem::path& folder, const std::filesystem::path& file,
                   const std::vector<BatchCase>& cases, const std::vector<Outcome>& outcomes);

}  // namespace angio::pipeline

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

/// Writes logs/CASE.json: the outcome, and the row that it is of.
void write_outcome(const std::filesystem::path& folder, const BatchCase& batch_case,
                   const Outcome& outcome);

/// By logs/CASE.json, or by the case's own files where there is none.
Outcome last_outcome(const std::filesystem::path& folder, const BatchCase& batch_case);

/// Writes `file` and the same as a page (.html): a row a case, with the numbers of those done.
void write_summary(const std::filesystem::path& folder, const std::filesystem::path& file,
                   const std::vector<BatchCase>& cases, const std::vector<Outcome>& outcomes);

}  // namespace angio::pipeline

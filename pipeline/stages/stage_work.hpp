#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "pipeline/case/case_folder.hpp"
#include "pipeline/case/stage_files.hpp"

namespace angio::pipeline {

/// What a stage works with beside its settings (a ConfigView): all that it sees is in its key.
struct StageWork {
  const StageFiles& files;         ///< the case's files that it has declared
  const RunRecord& run;            ///< what it may know of the run (StageDefinition::sees)
  std::string input;               ///< segmentation only; empty: take the case's own volume
  std::filesystem::path geometry;  ///< of a run's frames, in a file; empty: the header's
  std::filesystem::path out;       ///< becomes case/STAGE once the work is done
  Progress progress;

  // What the stage has to say beside its files.
  std::string input_description = {};     ///< for run.json; empty: as it was
  std::string backend = {}, device = {};  ///< the same
  double solver_seconds = 0.0;
  std::map<std::string, double> time_split = {};
  std::vector<std::string> warnings = {};
  /// Why what is in `out` is no result: it is kept for diagnosis, the stage fails. Empty: it is
  /// one.
  std::string failure = {};
  /// What was tried without being asked for gave no result: the stage counts as skipped.
  bool is_given_up = false;
};

/// Appends to a list of warnings.
void keep(std::vector<std::string>& warnings, const std::vector<std::string>& more);

}  // namespace angio::pipeline

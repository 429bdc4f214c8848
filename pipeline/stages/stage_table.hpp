#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/config/config.hpp"
#include "pipeline/stages/stage_work.hpp"

namespace angio::pipeline {

/// A stage: what it reads, and what it does with it.
struct StageDefinition {
  Stage stage;
  const char* name;
  /// The case's files that it may open, of earlier stages; folders end with '/'. Their content is
  /// in its key.
  std::vector<std::string> inputs;
  /// Files of its own that stand for INPUT where none is given.
  std::vector<std::string> own_inputs;
  /// Its settings as text, for its key: those that `work` sees.
  std::function<std::string(const Config&)> settings_text;
  /// What it may know of the run, for its key, too.
  std::function<RunRecord(const Config&, const RunRecord&)> sees;
  /// Empty: the stage does not apply. @throws Error, leaving `out` for the caller to remove
  std::function<void(StageWork&, const Config&)> work;
};

/// The stages in their order, of a vessel.
const std::vector<StageDefinition>& vessel_stages();

/// The same, or those of the paper's cloth.
const std::vector<StageDefinition>& stage_table(const Config& config);

}  // namespace angio::pipeline

#pragma once

#include <functional>
#include <string>
#include <utility>
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
  /// The kind of input that it is for (InputKind); empty: any.
  std::string input_kind;
  bool tells_of_failure = false;  ///< is it also run where the simulation has failed?
};

/// The stages of a kind of case, in their order, and the numbers that they come to.
struct Workflow {
  std::vector<StageDefinition> stages;
  std::vector<std::string> metrics_files;  ///< that `metrics` may open
  /// metrics.json from what the stages have left so far; null where it does not apply, and where
  /// what was left is stale.
  std::function<nlohmann::json(const StageFiles&, const Config&, const RunRecord&)> metrics;
};

// What a stage may know of the run.
RunRecord see_nothing(const Config& config, const RunRecord& run);
RunRecord see_input(const Config& config, const RunRecord& run);
/// The backend that was asked for; otherwise the one that was taken is as good as any.
RunRecord see_backend(const Config& config, const RunRecord& run);
/// Everything but times and memory, which differ from run to run.
RunRecord see_run(const Config& config, const RunRecord& run);

template <class Settings>
Settings all_of(const Config& config) {
  return Settings(config);
}

/// A stage that works. The function that makes its settings makes the text of its key, too.
template <class Settings>
StageDefinition define_stage(Stage stage, std::vector<std::string> inputs,
                             RunRecord (*sees)(const Config&, const RunRecord&),
                             void (*work)(StageWork&, const Settings&),
                             Settings (*settings_of)(const Config&) = all_of<Settings>) {
  StageDefinition definition{stage, name(stage), std::move(inputs), {}, nullptr, sees, nullptr, {}};
  definition.settings_text = [settings_of](const Config& config) {
    return settings_of(config).text();
  };
  definition.work = [work, settings_of](StageWork& stage_work, const Config& config) {
    work(stage_work, settings_of(config));
  };
  return definition;
}

/// A stage that does not apply.
/// @param input_kind  but would to an input of that kind; empty: to any
StageDefinition without_work(Stage stage, std::string input_kind = {});

std::vector<std::string> together(std::vector<std::string> files,
                                  const std::vector<std::string>& more);

}  // namespace angio::pipeline

#include "pipeline/stages/stage_definition.hpp"

#include <utility>

#include "formats/case_file.hpp"

namespace angio::pipeline {

RunRecord see_nothing(const Config&, const RunRecord&) { return {}; }

RunRecord see_input(const Config&, const RunRecord& run) {
  RunRecord seen;
  seen.input_kind = run.input_kind;
  seen.input_sha256 = run.input_sha256;
  return seen;
}

RunRecord see_backend(const Config& config, const RunRecord& run) {
  RunRecord seen;
  const simulation::Backend asked = config.simulation.backend;
  seen.backend = asked == simulation::Backend::cpu    ? "cpu"
                 : asked == simulation::Backend::cuda ? "cuda"
                                                      : run.backend;
  return seen;
}

RunRecord see_run(const Config&, const RunRecord& run) {
  RunRecord seen = run;
  seen.stages.clear();
  seen.files.clear();
  for (const auto& [stage, record] : run.stages) {
    if (stage == Stage::report) continue;
    seen.stages[stage].status = record.status;
    seen.stages[stage].is_stale = record.is_stale;
    seen.stages[stage].warnings = record.warnings;
    const auto diagnosis = record.outputs.find(formats::case_file::kDiagnosis);
    if (diagnosis != record.outputs.end()) seen.stages[stage].outputs.insert(*diagnosis);
  }
  return seen;
}

StageDefinition without_work(Stage stage, std::string input_kind) {
  return {stage,
          name(stage),
          {},
          {},
          [](const Config&) { return std::string(); },
          see_nothing,
          nullptr,
          std::move(input_kind)};
}

std::vector<std::string> together(std::vector<std::string> files,
                                  const std::vector<std::string>& more) {
  files.insert(files.end(), more.begin(), more.end());
  return files;
}

}  // namespace angio::pipeline

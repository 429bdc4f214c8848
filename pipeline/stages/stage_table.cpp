#include "pipeline/stages/stage_table.hpp"

#include <fmt/format.h>

#include <string_view>

#include "core/error.hpp"
#include "core/text.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/experiments/experiment.hpp"
#include "pipeline/stages/stage_parts.hpp"

namespace angio::pipeline {
namespace {

using Files = std::vector<std::string>;

template <class Settings>
Settings all_of(const Config& config) {
  return Settings(config);
}

// ---- what a stage may know of the run ----------------------------------------------------------

RunRecord see_nothing(const Config&, const RunRecord&) { return {}; }

RunRecord see_input(const Config&, const RunRecord& run) {
  RunRecord seen;
  seen.input_kind = run.input_kind;
  seen.input_sha256 = run.input_sha256;
  return seen;
}

/// The backend that was asked for; otherwise the one that was taken is as good as any.
RunRecord see_backend(const Config& config, const RunRecord& run) {
  RunRecord seen;
  const simulation::Backend asked = config.simulation.backend;
  seen.backend = asked == simulation::Backend::cpu    ? "cpu"
                 : asked == simulation::Backend::cuda ? "cuda"
                                                      : run.backend;
  return seen;
}

/// Everything but times and memory, which differ from run to run.
RunRecord see_run(const Config&, const RunRecord& run) {
  RunRecord seen = run;
  seen.stages.clear();
  for (const auto& [stage, record] : run.stages) {
    if (stage == Stage::report) continue;
    seen.stages[stage].status = record.status;
    seen.stages[stage].is_stale = record.is_stale;
    seen.stages[stage].warnings = record.warnings;
    const auto diagnosis = record.outputs.find(kDiagnosis);
    if (diagnosis != record.outputs.end()) seen.stages[stage].outputs.insert(*diagnosis);
  }
  return seen;
}

// ---- the table ---------------------------------------------------------------------------------

/// A row. The function that makes the stage's settings makes the text of its key, too.
template <class Settings>
StageDefinition row(Stage stage, const char* stage_name, Files inputs,
                    RunRecord (*sees)(const Config&, const RunRecord&),
                    void (*work)(StageWork&, const Settings&),
                    Settings (*settings_of)(const Config&) = all_of<Settings>) {
  StageDefinition definition{stage, stage_name, std::move(inputs), {}, nullptr, sees, nullptr};
  definition.settings_text = [settings_of](const Config& config) {
    return settings_of(config).text();
  };
  definition.work = [work, settings_of](StageWork& stage_work, const Config& config) {
    work(stage_work, settings_of(config));
  };
  return definition;
}

StageDefinition no_work(Stage stage, const char* stage_name) {
  return {stage,       stage_name, {}, {}, [](const Config&) { return std::string(); },
          see_nothing, nullptr};
}

Files together(Files files, const Files& more) {
  files.insert(files.end(), more.begin(), more.end());
  return files;
}

std::vector<StageDefinition> vessel_table() {
  std::vector<StageDefinition> table = {
      row(Stage::segmentation, "segmentation", {}, see_input, do_segmentation),
      row(Stage::centerline, "centerline", {"segmentation/volume.nrrd", kLevelSet, kGivenSurface},
          see_nothing, do_centerline, centerline_settings),
      row(Stage::meshing, "meshing",
          {"segmentation/volume.nrrd", kLevelSet, kGivenSurface, kCenterlines, kNarrowedLumen},
          see_nothing, do_meshing),
      row(Stage::simulation, "simulation",
          {kCenterlines, "meshing/lumen.vtp", "meshing/balloon.vtp", "meshing/guidewire.vtp",
           "meshing/region.vtp", "meshing/air.vtu", "meshing/wall.vtu", kPlacement},
          see_backend, do_simulation),
      row(Stage::report, "report",
          together(
              {kLevelSet, "meshing/lumen.vtp", "meshing/guidewire.vtp", "centerline/lesions.json",
               "simulation/simulation.pvd", "simulation/timeseries.csv",
               "simulation/lumen_profile.csv", "simulation/frames/"},
              metrics_files()),
          see_run, do_report)};
  table.front().own_inputs = {"segmentation/volume.nrrd", kGivenSurface};
  return table;
}

std::vector<StageDefinition> cloth_table() {
  return {
      no_work(Stage::segmentation, "segmentation"), no_work(Stage::centerline, "centerline"),
      row(Stage::meshing, "meshing", {}, see_input, do_cloth_meshing),
      row(Stage::simulation, "simulation", {"meshing/cloth.vtp"}, see_nothing, do_cloth_simulation),
      row(Stage::report, "report", together({"simulation/frames/"}, metrics_files()), see_run,
          do_cloth_report)};
}

}  // namespace

CenterlineSettings centerline_settings(const Config& config) {
  Config seen = config;
  if (seen.narrowing.percent <= 0.0) {
    const centerline::LesionOptions nowhere;
    seen.lesion.centerline = nowhere.centerline;
    seen.lesion.abscissa_mm = nowhere.abscissa_mm;
  }
  return CenterlineSettings(seen);
}

const std::vector<StageDefinition>& vessel_stages() {
  static const std::vector<StageDefinition> kTable = vessel_table();
  return kTable;
}

const std::vector<StageDefinition>& stage_table(const Config& config) {
  static const std::vector<StageDefinition> kCloth = cloth_table();
  return is_cloth(config) ? kCloth : vessel_stages();
}

const char* name(Stage stage) { return vessel_stages()[std::size_t(stage)].name; }

Stage parse_stage(std::string_view text) {
  std::vector<std::string> names;
  for (const StageDefinition& definition : vessel_stages()) {
    if (text == definition.name) return definition.stage;
    names.emplace_back(definition.name);
  }
  const std::string guess = guess_name(text, names);
  throw Error(ExitCode::usage,
              fmt::format("no stage is called {}{} (the stages: segmentation centerline meshing "
                          "simulation report)",
                          text, guess.empty() ? "" : fmt::format(", did you mean {}?", guess)));
}

}  // namespace angio::pipeline

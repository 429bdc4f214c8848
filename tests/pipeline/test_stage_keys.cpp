#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <set>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "pipeline/experiments/cloth.hpp"
#include "pipeline/experiments/workflow.hpp"
#include "pipeline/stages/stage_keys.hpp"
#include "pipeline/stages/stage_settings.hpp"
#include "pipeline/stages/stage_table.hpp"
#include "run_program.hpp"
#include "testing/pipeline/other_value.hpp"

namespace angio::pipeline {
namespace {

/// Which stages of a table have another key when a setting is changed.
std::set<Stage> stages_changed(const Config& config, const std::string& key) {
  Config other = config;
  apply_setting(other, key + "=" + test::other_value(config, key));
  std::set<Stage> changed;
  for (const StageDefinition& stage : workflow_of(config).stages)
    if (stage_key(stage, config, {}, {}) != stage_key(stage, other, {}, {}))
      changed.insert(stage.stage);
  return changed;
}

Config cloth_config() {
  Config config;
  apply_preset(config, "paper-cloth");
  return config;
}

Config narrowing_config() {
  Config config;
  apply_setting(config, "lesion.narrow_percent=50");
  return config;
}

TEST(StageTable, IsInTheOrderOfTheStages) {
  for (const Config& config : {Config(), cloth_config()}) {
    ASSERT_EQ(workflow_of(config).stages.size(), std::size_t(kStageCount));
    for (int s = 0; s < kStageCount; ++s)
      EXPECT_EQ(workflow_of(config).stages[std::size_t(s)].stage, Stage(s));
  }
}

TEST(StageTable, AStageReadsWhatEarlierStagesHaveLeft) {
  for (const Config& config : {Config(), cloth_config()})
    for (const StageDefinition& stage : workflow_of(config).stages)
      for (const std::string& file : stage.inputs)
        EXPECT_LT(parse_stage(file.substr(0, file.find('/'))), stage.stage) << file;
}

TEST(StageKey, ChangesWithEverySettingOfTheTable) {
  Config config;
  for (const Setting& setting : settings(config)) {
    std::set<Stage> changed = stages_changed(Config(), setting.key);
    changed.merge(stages_changed(cloth_config(), setting.key));
    EXPECT_FALSE(changed.empty()) << setting.key << " changes no stage's key";
  }
}

// The bytes of the parts that a view hands out, as far as they lie in the Config itself: text and
// lists show in their lengths.
template <auto... kParts>
std::string bytes_seen(const ConfigView<kParts...>&, const Config& config) {
  std::string bytes;
  const auto add = [&](const auto& part) {
    bytes.append(static_cast<const char*>(static_cast<const void*>(&part)), sizeof(part));
  };
  (add(std::invoke(kParts, config)), ...);
  return bytes;
}

/// Whatever a stage can read changes its text; whatever it cannot does not.
template <class View>
void expect_text_follows_what_is_seen(const Config& base) {
  Config config = base;
  for (const Setting& setting : settings(config)) {
    const std::string value = test::other_value(base, setting.key);
    const std::string text = View(config).text(), seen = bytes_seen(View(config), config);
    const std::string former = setting.get();
    setting.set(value);
    EXPECT_EQ(View(config).text() != text, bytes_seen(View(config), config) != seen)
        << setting.key << " = " << value;
    setting.set(former);
  }
}

TEST(ConfigView, HoldsInItsTextAllThatCanBeReadFromIt) {
  expect_text_follows_what_is_seen<InputSettings>({});
  expect_text_follows_what_is_seen<SegmentationSettings>({});
  expect_text_follows_what_is_seen<CenterlineSettings>({});
  expect_text_follows_what_is_seen<MeshingSettings>({});
  expect_text_follows_what_is_seen<SimulationSettings>({});
  expect_text_follows_what_is_seen<ReportSettings>({});
  expect_text_follows_what_is_seen<ClothSettings>({});
}

template <class View, auto kPart>
concept CanRead = requires(const View& view) {
  view.template get<kPart>();
};

TEST(ConfigView, DoesNotHandOutWhatItsTextDoesNotHold) {
  EXPECT_TRUE((CanRead<MeshingSettings, &Config::balloon>));
  EXPECT_TRUE((CanRead<MeshingSettings, &Config::wall_model>));
  EXPECT_FALSE((CanRead<MeshingSettings, &Config::simulation>));
  EXPECT_FALSE((CanRead<SimulationSettings, &Config::balloon>));
  EXPECT_FALSE((CanRead<SimulationSettings, &Config::wall_layers>));
  EXPECT_FALSE((CanRead<SegmentationSettings, &Config::lesion>));
  EXPECT_FALSE((CanRead<ReportSettings, &Config::simulation>));
}

TEST(StageKey, HoldsWhatMoreThanOneStageReads) {
  using enum Stage;
  const std::map<std::string, std::set<Stage>> read_by = {
      {"wall.model", {meshing}},
      {"wall.thickness_ratio", {meshing, simulation}},
      {"wall.layer_fractions", {meshing}},  // and the simulation by the file, below
      {"wall.elements_per_layer", {meshing}},
      {"wall.plaque_elements", {meshing}},
      {"balloon.shaft_diameter_mm", {meshing, simulation}},
      {"balloon.folds", {meshing, simulation}},
      {"mesh.keep", {meshing, simulation}},
      {"lesion.min_stenosis_percent", {centerline, meshing, report}},
      {"lesion.abscissa_mm", {meshing, report}},
      {"inflation.hold_s", {simulation}},
      {"flow.viscosity_mpa_s", {report}},
      {"flow.vessel", {report}},
      {"view.primary_limit_degrees", {report}},
      {"input.spacing_mm", {reconstruction, segmentation}},
      {"reconstruction.window", {reconstruction}}};
  for (const auto& [key, stages] : read_by) EXPECT_EQ(stages_changed({}, key), stages) << key;
  EXPECT_EQ(stages_changed(narrowing_config(), "lesion.abscissa_mm"),
            (std::set<Stage>{centerline, meshing, report}));
}

TEST(StageKey, ChangesWithEveryFileThatIsRead) {
  const Config config;
  for (const StageDefinition& stage : workflow_of(config).stages)
    for (const std::string& file : stage.inputs) {
      const std::string none = stage_key(stage, config, {}, {});
      EXPECT_NE(stage_key(stage, config, {}, {{file, "1"}}), none) << file;
      EXPECT_NE(stage_key(stage, config, {}, {{file, "1"}}),
                stage_key(stage, config, {}, {{file, "2"}}))
          << file;
    }
  EXPECT_TRUE(names_file(workflow_of(config).stages[std::size_t(Stage::simulation)].inputs,
                         "meshing/wall.vtu"));
}

TEST(StageKey, OfTheReportChangesWithWhatTheStagesSaid) {
  const StageDefinition& report = vessel_workflow().stages.back();
  RunRecord run;
  run.stages[Stage::meshing].status = "done";
  const std::string before = stage_key(report, {}, run, {});
  run.stages[Stage::meshing].seconds = 3.0;
  run.stages[Stage::meshing].peak_memory_mib = 7.0;
  EXPECT_EQ(stage_key(report, {}, run, {}), before);
  run.stages[Stage::meshing].warnings = {"a warning"};
  EXPECT_NE(stage_key(report, {}, run, {}), before);
}

TEST(StageKey, HoldsTheBackendThatWasAskedFor) {
  const StageDefinition& simulation = vessel_workflow().stages[std::size_t(Stage::simulation)];
  RunRecord run;
  run.backend = "cpu";
  Config cpu, cuda;
  cpu.simulation.backend = simulation::Backend::cpu;
  cuda.simulation.backend = simulation::Backend::cuda;
  EXPECT_EQ(stage_key(simulation, {}, run, {}), stage_key(simulation, cpu, run, {}));
  EXPECT_NE(stage_key(simulation, {}, run, {}), stage_key(simulation, cuda, run, {}));
}

TEST(StageFiles, RefusesWhatWasNotDeclaredAndRecordsTheRest) {
  test::CommandFolder root;
  write_text_atomically(root / "meshing/lumen.vtp", "lumen");
  const StageFiles files(CaseFolder(root.path()), {"meshing/lumen.vtp", "simulation/frames/"});
  EXPECT_TRUE(files.exists("meshing/lumen.vtp"));
  EXPECT_FALSE(files.exists("simulation/frames/balloon_000000.vtp"));
  EXPECT_THROW((void)files.path("meshing/wall.vtu"), InternalError);
  EXPECT_THROW((void)files.exists("meshing/wall.vtu"), InternalError);
  EXPECT_THROW((void)files.path("simulation/frames.txt"), InternalError);
  EXPECT_EQ(files.opened(),
            (std::set<std::string>{"meshing/lumen.vtp", "simulation/frames/balloon_000000.vtp"}));
}

/// A case whose stages have been done, each with a file.
struct DoneCase {
  test::CommandFolder root;
  CaseFolder folder{root.path()};
  Config config;
  RunRecord run;

  DoneCase() {
    const char* files[] = {"reconstruction/volume.nrrd", "segmentation/lumen_level_set.nrrd",
                           "centerline/centerlines.vtp", "meshing/placement.json",
                           "simulation/summary.json",    "report/index.html"};
    for (const StageDefinition& stage : workflow_of(config).stages) {
      const char* file = files[int(stage.stage)];
      write_text_atomically(root / file, "<html>\n<body>\nfirst</body>\n");
      StageRecord& record = run.stages[stage.stage];
      record.status = "done";
      record.key = stage_key(stage, config, run, folder.hashes(stage.inputs));
      record.outputs = folder.hashes(stage.stage);
    }
  }
  [[nodiscard]] std::set<Stage> stale() {
    mark_stale(folder, workflow_of(config), config, run);
    std::set<Stage> stages;
    for (const auto& [stage, record] : run.stages)
      if (record.is_stale) stages.insert(stage);
    return stages;
  }
};

using enum Stage;

TEST(MarkStale, LeavesACaseAloneThatHasNotChanged) {
  EXPECT_EQ(DoneCase().stale(), std::set<Stage>{});
}

TEST(MarkStale, GoesOnFromTheStageThatHasChangedToTheLast) {
  DoneCase done;
  apply_setting(done.config, "mesh.smoothing_iterations=3");
  EXPECT_EQ(done.stale(), (std::set<Stage>{meshing, simulation, report}));
  apply_setting(done.config, "mesh.smoothing_iterations=" +
                                 std::to_string(Config().lumen_mesh.smoothing_iterations));
  EXPECT_EQ(done.stale(), std::set<Stage>{});
}

TEST(MarkStale, SeesThatAStageHasLeftSomethingElse) {
  DoneCase done;
  done.run.stages[centerline].outputs["centerline/centerlines.vtp"] = "another hash";
  EXPECT_EQ(done.stale(), (std::set<Stage>{meshing, simulation, report}));
}

TEST(MarkStale, SeesThatAFileIsMissing) {
  DoneCase done;
  std::filesystem::remove_all(done.root / "simulation");
  EXPECT_EQ(done.stale(), (std::set<Stage>{simulation, report}));
}

TEST(MarkStale, TellsOfAFailureThatIsNoLongerTheConfigurations) {
  DoneCase done;
  done.run.stages[simulation].status = "failed";
  EXPECT_EQ(done.stale(), std::set<Stage>{report});  // it was made of another status
  apply_setting(done.config, "inflation.hold_s=3");
  EXPECT_EQ(done.stale(), (std::set<Stage>{simulation, report}));
}

TEST(MarkStale, IsKeptInRunJsonWithWhatWasThere) {
  DoneCase done;
  apply_setting(done.config, "inflation.hold_s=3");
  ASSERT_EQ(done.stale(), (std::set<Stage>{simulation, report}));
  done.folder.write_record(done.run);
  const auto root = nlohmann::json::parse(test::file_text(done.root / "run.json"));
  EXPECT_EQ(root.at("stages").at("simulation").at("status"), "stale");
  const RunRecord again = done.folder.read_record();
  EXPECT_TRUE(again.stages.at(simulation).is_stale);
  EXPECT_EQ(again.stages.at(simulation).status, "done");
}

TEST(MarkReport, PutsANoticeInAndTakesItOut) {
  DoneCase done;
  const std::string before = test::file_text(done.root / "report/index.html");
  mark_report(done.folder, true);
  mark_report(done.folder, true);
  const std::string marked = test::file_text(done.root / "report/index.html");
  EXPECT_NE(marked.find("This report is stale."), std::string::npos);
  EXPECT_LT(marked.find("This report is stale."), marked.find("first"));
  mark_report(done.folder, false);
  EXPECT_EQ(test::file_text(done.root / "report/index.html"), before);
}

}  // namespace
}  // namespace angio::pipeline

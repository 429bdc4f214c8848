#include <gtest/gtest.h>

#include "core/atomic_file.hpp"
#include "pipeline/case/case_status.hpp"
#include "pipeline/case/metrics.hpp"
#include "run_program.hpp"

namespace angio::pipeline {
namespace {

// A case whose stages have all been done.
struct DoneCase {
  test::CommandFolder root;
  CaseFolder folder{root.path()};
  RunRecord record;

  explicit DoneCase(const std::string& placement = R"({"balloon": {}, "status": "done"})") {
    write_text_atomically(root / "centerline/centerlines.vtp", "lines");
    write_text_atomically(root / "meshing/placement.json", placement);
    set(Stage::centerline, "done");
    set(Stage::meshing, "done");
    set(Stage::simulation, "done");
  }
  void set(Stage stage, const std::string& status) { record.stages[stage].status = status; }
  [[nodiscard]] CaseStatus status() const {
    return case_status(StageFiles(folder, metrics_files()), record);
  }
};

TEST(CaseStatus, IsDoneWhenAllStagesAre) {
  const DoneCase done;
  EXPECT_EQ(done.status().status, "done");
  EXPECT_TRUE(done.status().has_result());
}

TEST(CaseStatus, IsNotThereBeforeTheSimulationIs) {
  DoneCase half;
  half.record.stages.erase(Stage::simulation);
  EXPECT_EQ(half.status().status, "");
}

TEST(CaseStatus, IsStaleAsSoonAsOneStageIs) {
  DoneCase stale;
  stale.record.stages[Stage::simulation].is_stale = true;
  EXPECT_EQ(stale.status().status, "stale");
  EXPECT_FALSE(stale.status().has_result());
  stale.record.stages[Stage::simulation].is_stale = false;
  EXPECT_EQ(stale.status().status, "done");
}

TEST(CaseStatus, OfAFailureOfAnotherStateIsStale) {
  DoneCase failed;
  failed.set(Stage::simulation, "failed");
  failed.record.stages[Stage::simulation].is_stale = true;
  EXPECT_EQ(failed.status().status, "stale");
}

TEST(CaseStatus, OfAFailedStageSaysWhichAndWhy) {
  DoneCase failed;
  failed.set(Stage::simulation, "failed");
  failed.record.stages[Stage::simulation].warnings = {"balloon and wall cross"};
  EXPECT_EQ(failed.status().status, "failed");
  EXPECT_EQ(failed.status().reason, "the stage simulation failed: balloon and wall cross");
}

TEST(CaseStatus, WithoutAPlaceForABalloonIsWhatMeshingSays) {
  const DoneCase small(R"({"status": "not_determined", "status_reason": "too narrow"})");
  EXPECT_TRUE(is_untreated(small.folder));
  EXPECT_EQ(small.status().status, "not_determined");
  EXPECT_EQ(small.status().reason, "too narrow");
  EXPECT_FALSE(is_untreated(DoneCase().folder));
}

TEST(CaseStatus, OfATreatmentThatTwoRunsDisagreeOnIsNotDetermined) {
  const DoneCase apart,
      no_lesion(R"({"balloon": {}, "status": "no_lesion", "status_reason": "-"})");
  for (const DoneCase* one : {&apart, &no_lesion})
    write_text_atomically(one->root / "simulation/summary.json", R"({"guard_reason": "0.2, 0.4"})");
  EXPECT_EQ(apart.status().status, "not_determined");
  EXPECT_EQ(apart.status().reason, "0.2, 0.4");
  EXPECT_EQ(no_lesion.status().status, "no_lesion");
  write_text_atomically(apart.root / "simulation/summary.json", R"({"guard_reason": ""})");
  EXPECT_EQ(apart.status().status, "done");
}

TEST(Run, DoesNotTreatANarrowVesselUnasked) {
  test::CommandFolder folder;
  const std::string run =
      "run phantom:straight,radius=0.6,length=12,spacing=0.15 --preset draft --quiet -o '" +
      folder / "c" + "'";
  const test::ProgramResult result = test::run_program(run);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const nlohmann::json metrics = read_json(folder.path() / "c/metrics.json");
  EXPECT_EQ(metrics.at("status"), "no_lesion");
  EXPECT_TRUE(metrics.at("result").at("mld_mm").is_null());
  EXPECT_TRUE(metrics.at("balloon").at("nominal_diameter_mm").is_null());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "c/simulation"));
  const std::string page = test::file_text(folder.path() / "c/report/index.html");
  EXPECT_NE(page.find("No stenosis found."), std::string::npos);
  EXPECT_NE(page.find("narrower than 1.5 mm"), std::string::npos);
}

}  // namespace
}  // namespace angio::pipeline

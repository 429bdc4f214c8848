#include <gtest/gtest.h>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "pipeline/case/case_status.hpp"
#include "pipeline/case/doubts.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/case/read_out.hpp"
#include "run_program.hpp"
#include "segmentation/segmentation.hpp"

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

TEST(CaseStatus, WithoutAPlaceForABalloonSaysWhyThereIsNothingToShow) {
  const DoneCase small(R"({"status": "not_determined", "status_reason": "it is too narrow"})");
  try {
    refuse_untreated(small.folder);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no simulation, because it is too narrow. Try "),
              std::string::npos)
        << error.what();
  }
  EXPECT_NO_THROW(refuse_untreated(DoneCase().folder));
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

TEST(CaseStatus, OfViewsThatDoNotTellTheirVesselsIsNotDetermined) {
  DoneCase views;
  const auto quality = [&](const char* text) {
    write_text_atomically(views.root / "reconstruction/quality.json", text);
    return views.status();
  };
  EXPECT_EQ(quality(R"({"doubt": "31 % explained"})").status, "done") << "they were not used";
  views.set(Stage::reconstruction, "done");
  EXPECT_EQ(views.status().status, "not_determined");
  EXPECT_EQ(views.status().reason, "31 % explained");
  EXPECT_EQ(quality(R"({"doubt": null})").status, "done");
  EXPECT_EQ(quality(R"({"method": "fdk"})").status, "done");
  // Nor is it certain then that there is no stenosis.
  DoneCase healthy(R"({"status": "no_lesion", "status_reason": "none was found"})");
  healthy.set(Stage::reconstruction, "done");
  EXPECT_EQ(healthy.status().status, "no_lesion");
  write_text_atomically(healthy.root / "reconstruction/quality.json", R"({"doubt": "31 %"})");
  EXPECT_EQ(healthy.status().status, "not_determined");
  EXPECT_EQ(healthy.status().reason, "31 %");
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
  EXPECT_NE(page.find("No certain stenosis."), std::string::npos);
  EXPECT_NE(page.find("narrower than 1.5 mm"), std::string::npos);
  EXPECT_EQ(page.find("is passed over"), std::string::npos);  // what is healthy is no stenosis
}

// One sweep a second leaves the forces off balance: of a place that was asked for the run has
// failed, of a healthy one it goes on without the balloon that was tried there.
TEST(Run, FailsWithABalloonThatWasAskedForAlone) {
  test::CommandFolder folder;
  const auto run = [&](const std::string& name, const std::string& place) {
    return test::run_program(
        "run phantom:straight,radius=1.2,length=24,spacing=0.3 --preset draft --quiet -o '" +
        folder / name + "' --set simulation.frame_s=1 simulation.contact_distance_mm=0.001 " +
        "simulation.sweeps=1 balloon.nominal_diameter_mm=5" + place);
  };
  const auto metrics = [&](const char* name) {
    return read_json(folder.path() / name / "metrics.json");
  };
  const test::ProgramResult asked = run("asked", " lesion.abscissa_mm=12");
  EXPECT_EQ(asked.exit_code, 65);
  EXPECT_NE(asked.error.find("off balance"), std::string::npos) << asked.error;
  EXPECT_EQ(metrics("asked").at("status"), "failed");
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "asked/simulation/frames"));

  const test::ProgramResult healthy = run("healthy", "");
  EXPECT_EQ(healthy.exit_code, 0) << healthy.error;
  EXPECT_NE(healthy.error.find("off balance"), std::string::npos) << healthy.error;
  const nlohmann::json told = metrics("healthy");
  EXPECT_EQ(told.at("status"), "no_lesion");
  EXPECT_NE(told.at("status_reason").get<std::string>().find("no result"), std::string::npos);
  EXPECT_TRUE(told.at("result").at("mld_mm").is_null());
  EXPECT_TRUE(told.at("simulation").at("frame_count").is_null());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "healthy/simulation/frames"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "healthy/simulation/diagnosis.json"));
  const nlohmann::json record = read_json(folder.path() / "healthy/run.json");
  EXPECT_EQ(record.at("stages").at("simulation").at("status"), "skipped");

  const auto made =
      std::filesystem::last_write_time(folder.path() / "healthy/simulation/diagnosis.json");
  EXPECT_EQ(run("healthy", "").exit_code, 0);
  EXPECT_EQ(std::filesystem::last_write_time(folder.path() / "healthy/simulation/diagnosis.json"),
            made)
      << "it is not tried again";
}

// metrics.json of a treated lesion, and what its stages have warned of.
struct TreatedCase {
  nlohmann::json metrics = {
      {"status", "done"},
      {"status_reason", nullptr},
      {"lesion",
       {{"mld_mm", 1.2}, {"diameter_stenosis_percent", 60.0}, {"reference_diameter_mm", 3.0}}},
      {"balloon", {{"nominal_diameter_mm", 3.0}, {"peak_pressure_atm", 8.0}}},
      {"result",
       {{"mld_mm", 2.25}, {"diameter_stenosis_percent", 25.0}, {"recoil_percent", 28.0}}}};
  RunRecord record;

  TreatedCase() {
    record.stages[Stage::simulation].status = "done";
    record.stages[Stage::meshing].warnings = {"the wall is thin"};
  }
  [[nodiscard]] std::vector<std::string> lines() const { return read_out(metrics, record); }
};

TEST(ReadOut, SaysWhatWasBeforeWhatIsAfterAndWhatToDoubt) {
  TreatedCase treated;
  ASSERT_EQ(treated.lines().size(), 3u);
  EXPECT_EQ(treated.lines()[0],
            "before   minimal lumen diameter 1.20 mm, 60 % stenosis of 3.00 mm");
  EXPECT_EQ(treated.lines()[1],
            "after    minimal lumen diameter 2.25 mm, 25 % stenosis, recoil 28 %; balloon of 3.00 "
            "mm at 8.0 atm");
  EXPECT_EQ(treated.lines()[2], "to doubt the wall is thin");
  treated.metrics["lesion"]["listed_count"] = 2;
  EXPECT_EQ(treated.lines()[0],
            "before   minimal lumen diameter 1.20 mm, 60 % stenosis of 3.00 mm; 2 stenoses are "
            "listed, this one is looked at");
  treated.metrics["result"]["diameter_stenosis_percent"] = -151.0;
  EXPECT_NE(treated.lines()[1].find("2.25 mm, 151 % wider than the reference, recoil"),
            std::string::npos);
  treated.record.stages[Stage::centerline].warnings = {"two vessels touch"};
  EXPECT_EQ(treated.lines()[2], "to doubt two vessels touch (1 more in the report)");
  const std::string throat = std::string(kUnmeasuredThroat) + " (0.65 mm)";
  treated.record.stages[Stage::meshing].warnings.push_back(throat);
  EXPECT_EQ(treated.lines()[2], "to doubt " + throat + " (2 more in the report)");
  treated.record.stages[Stage::simulation].warnings = {"the balloon kinks", "it slips"};
  EXPECT_EQ(treated.lines()[2], "to doubt the balloon kinks (4 more in the report)");
  const std::string bone = std::string(segmentation::kDoubtfulLumen) + "it is bone";
  treated.record.stages[Stage::segmentation].warnings = {"a piece was left out", bone};
  EXPECT_EQ(treated.lines()[2], "to doubt " + bone + " (6 more in the report)");
}

TEST(ReadOut, WhatWasMadeOfTheInputIsTheLastThingToDoubt) {
  TreatedCase treated;
  treated.record.stages[Stage::segmentation].warnings = {
      std::string(kUnitGuessed) + "; in mm " + std::string(kOnlyUnit),
      std::string(kRepaired) + "1 hole filled"};
  EXPECT_EQ(treated.lines()[2], "to doubt the wall is thin (2 more in the report)");
  treated.record.stages[Stage::meshing].warnings.clear();
  treated.record.stages[Stage::segmentation].warnings.erase(
      treated.record.stages[Stage::segmentation].warnings.begin());
  EXPECT_EQ(treated.lines()[2], "to doubt nothing that was noticed (1 repair in the report)");
  treated.record.stages[Stage::segmentation].warnings = {std::string(kUnitGuessed) +
                                                         "; in cm it would be as likely"};
  treated.record.stages[Stage::centerline].warnings = {"two vessels touch"};
  EXPECT_NE(treated.lines()[2].find("unit"), std::string::npos) << treated.lines()[2];
}

TEST(ReadOut, OfACaseThatNothingIsSaidOfHasNothingToDoubt) {
  TreatedCase treated;
  treated.record.stages[Stage::meshing].warnings.clear();
  EXPECT_EQ(treated.lines()[2], "to doubt nothing that was noticed");
}

TEST(ReadOut, TellsABoundOfAThroatThatIsNarrowerThanAVoxel) {
  TreatedCase coarse;
  coarse.metrics["lesion"]["resolution_mm"] = 1.0;
  coarse.metrics["lesion"]["stenosis_at_least_percent"] = 66.7;
  EXPECT_EQ(coarse.lines()[0],
            "before   narrower than a voxel of 1.00 mm, at least 67 % stenosis of 3.00 mm");
  coarse.record.input_kind = "surface";
  EXPECT_EQ(coarse.lines()[0],
            "before   narrower than the voxels of 1.00 mm that the surface was made from, at least "
            "67 % stenosis of 3.00 mm");
}

TEST(ReadOut, HasNoNumberOfAResultThatIsNone) {
  TreatedCase open;
  open.metrics["status"] = "not_determined";
  open.metrics["status_reason"] = "two runs disagree";
  for (auto& [key, value] : open.metrics["result"].items()) value = nullptr;
  ASSERT_EQ(open.lines().size(), 3u);
  EXPECT_EQ(open.lines()[1], "after    not determined");
  EXPECT_EQ(open.lines()[2], "to doubt two runs disagree (1 more in the report)");
  open.metrics["status"] = "no_lesion";
  EXPECT_EQ(open.lines()[0], "before   minimal lumen diameter 1.20 mm at the trial place");
  EXPECT_EQ(open.lines()[1], "after    no lesion was treated");
}

TEST(ReadOut, NamesTheWorkingViewWhereThereIsOne) {
  TreatedCase seen;
  seen.metrics["working_view"] = {{"label", "LAO 32 CRA 15"},
                                  {"foreshortening_percent", 1.2},
                                  {"overlap_percent", 0.0},
                                  {"patient_axes", "stated"}};
  ASSERT_EQ(seen.lines().size(), 4u);
  EXPECT_EQ(seen.lines()[2], "view     LAO 32 CRA 15: foreshortening 1 %, overlap 0 %");
  seen.metrics["working_view"]["patient_axes"] = "assumed";
  EXPECT_EQ(seen.lines()[2],
            "view     LAO 32 CRA 15: foreshortening 1 %, overlap 0 %, if the input's axes are the "
            "patient's");
}

TEST(ReadOut, SaysWhyNothingIsSimulated) {
  TreatedCase left;
  left.record.stages[Stage::simulation].status = "skipped";
  left.metrics["status"] = "no_lesion";
  left.metrics["status_reason"] = "no stenosis was found";
  ASSERT_EQ(left.lines().size(), 3u);
  EXPECT_EQ(left.lines()[0], "result   none is simulated: no stenosis was found");
  EXPECT_TRUE(left.lines()[1].starts_with("to try   another place (--set lesion.centerline"));
  EXPECT_EQ(left.lines()[2], "to doubt the wall is thin");
  left.record.stages[Stage::meshing].warnings.clear();
  EXPECT_EQ(left.lines().size(), 2u);
}

TEST(ReadOut, IsSilentBeforeTheSimulation) {
  TreatedCase half;
  half.record.stages.erase(Stage::simulation);
  EXPECT_TRUE(half.lines().empty());
  EXPECT_TRUE(read_out(empty_metrics(), RunRecord()).empty());
}

}  // namespace
}  // namespace angio::pipeline

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/pipeline/run_program.hpp"

// From X-ray frames to the lumen, as a user goes.
namespace angio::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::CommandFolder;
using test::file_text;
using test::json_of;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;
using testing::Not;

class RotationalRuns : public testing::Test {
 protected:
  /// Makes a run around a short vessel with a stenosis of 60 %.
  std::string make_run(const std::string& name, const std::string& options,
                       const std::string& phantom = "concentric --length 20") {
    const std::string out = folder_ / name;
    const ProgramResult made =
        run_program("phantom " + phantom + " --format xa-run " + options + " -o '" + out + "'");
    EXPECT_EQ(made.exit_code, 0) << made.error;
    return out + "/run";
  }
  ProgramResult run(const std::string& input, const std::string& name,
                    const std::string& more = "--until centerline") {
    return run_program("run '" + input + "' -o '" + folder_ / name + "' " + more);
  }
  void expect_stenosis(const std::string& name, double tolerance_mm) {
    const json lesions = json_of(folder_.path() / name / "centerline/lesions.json");
    ASSERT_EQ(lesions.size(), 1u);
    EXPECT_NEAR(lesions[0].at("mld_mm").get<double>(), 1.2, tolerance_mm);
  }
  CommandFolder folder_;
};

TEST_F(RotationalRuns, LeadToTheLumenAndAreUpToDateAfterwards) {
  const std::string input = make_run("xa", "--frames 120");
  const ProgramResult first = run(input, "case");
  ASSERT_EQ(first.exit_code, 0) << first.error;
  expect_stenosis("case", 0.06);
  const json record = json_of(folder_.path() / "case/run.json");
  EXPECT_EQ(record.at("input").at("kind"), "run");
  EXPECT_EQ(record.at("stages").at("reconstruction").at("status"), "done");
  const json quality = json_of(folder_.path() / "case/reconstruction/quality.json");
  EXPECT_EQ(quality.at("frames"), 120);
  EXPECT_LT(quality.at("residual_pixels").get<double>(), 0.3);
  EXPECT_EQ(quality.at("device").is_null(), quality.at("backend") == "cpu");
  const ProgramResult again = run(input, "case");
  EXPECT_THAT(again.error, HasSubstr("reconstruction up to date"));
  EXPECT_EQ(run_program("segment '" + folder_ / "case" + "'").exit_code, 0);
  const ProgramResult changed =
      run(input, "case", "--until centerline --set reconstruction.window=hann");
  EXPECT_THAT(changed.error, HasSubstr("reconstruction done"));
  EXPECT_THAT(changed.error, HasSubstr("segmentation  done"));
}

TEST_F(RotationalRuns, ThatWobbleAreCalibrated) {
  const ProgramResult result =
      run(make_run("xa", "--frames 120 --wobble 0.5 --wobble-angle 0.3"), "case");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("beside the path that it was said to go"));
  // By the header's steps, however far a fitted frame lies from its neighbours.
  EXPECT_EQ(json_of(folder_.path() / "case/reconstruction/quality.json").at("method"), "fdk");
  expect_stenosis("case", 0.08);
}

TEST_F(RotationalRuns, AreSubtractedFromTheirMaskRun) {
  const ProgramResult result = run(make_run("xa", "--frames 100 --mask-run"), "case");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_TRUE(json_of(folder_.path() / "case/reconstruction/quality.json").at("subtracted"));
  expect_stenosis("case", 0.06);
}

TEST_F(RotationalRuns, OfFewFramesGiveTheVesselsAlone) {
  const std::string input = make_run("xa", "--frames 11 --arc 180");
  ASSERT_EQ(run(input, "case").exit_code, 0);
  const json quality = json_of(folder_.path() / "case/reconstruction/quality.json");
  EXPECT_EQ(quality.at("method"), "few-views");
  EXPECT_TRUE(quality.at("converged"));
  EXPECT_FALSE(quality.at("gating").at("gated"));
  expect_stenosis("case", 0.1);
}

TEST_F(RotationalRuns, HaveTheirLinesFittedToTheFrames) {
  const std::string input = make_run("xa", "--frames 30");
  ASSERT_EQ(run(input, "case").exit_code, 0);
  const std::string lines = file_text(folder_.path() / "case/centerline/centerlines.vtp");
  const std::string fit = "fit '" + folder_ / "case" + "' ";
  const ProgramResult fitted = run_program(fit + "'" + input + "' -o '" + folder_ / "fit" + "'");
  ASSERT_EQ(fitted.exit_code, 0) << fitted.error;
  EXPECT_THAT(fitted.error, HasSubstr("by the frames"));
  const json result = json_of(folder_.path() / "fit/fit.json");
  EXPECT_TRUE(result.at("converged"));
  EXPECT_EQ(result.at("frames").size(), 30u);
  ASSERT_EQ(result.at("lesions").size(), 1u);
  EXPECT_NEAR(result.at("lesions")[0].at("mld_mm").get<double>(), 1.2, 0.05);
  EXPECT_GT(result.at("lesions")[0].at("mld_sd_mm").get<double>(), 0.0);
  EXPECT_THAT(file_text(folder_.path() / "fit/centerlines.vtp"),
              HasSubstr("RadiusStandardDeviation"));
  EXPECT_EQ(file_text(folder_.path() / "case/centerline/centerlines.vtp"), lines);

  const std::string other = make_run("other", "--frames 31");
  const ProgramResult refused = run_program(fit + "'" + other + "' -o '" + folder_ / "none" + "'");
  EXPECT_EQ(refused.exit_code, 65);
  EXPECT_EQ(refused.error_line_count(), 1) << refused.error;
  EXPECT_THAT(refused.error, HasSubstr("31"));
  EXPECT_FALSE(fs::exists(folder_.path() / "none"));

  std::ofstream(folder_.path() / "case/reconstruction/quality.json") << "{}";
  const ProgramResult damaged = run_program(fit + "'" + input + "' -o '" + folder_ / "none" + "'");
  EXPECT_EQ(damaged.exit_code, 65);
  EXPECT_THAT(damaged.error, HasSubstr("quality.json"));
}

TEST_F(RotationalRuns, ThatBeatAreGatedByTheirRWaves) {
  const std::string input =
      make_run("xa", "--spacing 0.6 --frames 133 --heartbeat 8", "coronary --stenosis 60");
  const ProgramResult inspected = run_program("inspect '" + input + "'");
  EXPECT_THAT(inspected.out, HasSubstr("R wave(s) of the heart"));
  EXPECT_THAT(inspected.out, HasSubstr("frames of one phase"));
  const ProgramResult result = run(input, "case");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json gating = json_of(folder_.path() / "case/reconstruction/quality.json").at("gating");
  EXPECT_TRUE(gating.at("gated"));
  EXPECT_TRUE(gating.at("by_r_waves"));
  EXPECT_NEAR(gating.at("heart_rate_per_min").get<double>(), 70.0, 4.0);
  const json phases = json_of(folder_.path() / "xa/truth.json").at("run").at("motion");
  for (const json& frame : gating.at("frames_used"))
    EXPECT_NEAR(phases.at("cardiac_phases").at(frame.get<std::size_t>() - 1).get<double>(), 0.75,
                0.13);
  const json truth = json_of(folder_.path() / "xa/truth.json").at("lesions").at(0);
  const json lesions = json_of(folder_.path() / "case/centerline/lesions.json");
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_NEAR(lesions[0].at("mld_mm").get<double>(), truth.at("mld_mm").get<double>(), 0.2);
}

TEST_F(RotationalRuns, ThatCannotGiveAVolumeAreRefusedInOneLine) {
  for (const auto& [options, why] : {std::pair{"--arc 30", "turns by 30 degrees"},
                                     std::pair{"--frames 3 --arc 1", "1 degree"}}) {
    const ProgramResult result = run(make_run("xa", options), "case");
    EXPECT_EQ(result.exit_code, 65);
    EXPECT_THAT(result.error, HasSubstr(why));
    EXPECT_FALSE(fs::exists(folder_.path() / "case"));
  }
}

TEST_F(RotationalRuns, CutShortOrWithAnotherGeometryLeaveNothingBehind) {
  const std::string input = make_run("xa", "--frames 40");
  const std::string file = input + "/IM0001.dcm", table = folder_ / "nan.csv";
  std::ofstream(table) << "1,0,0,0,0,1,0,0,0,0,1,nan\n";
  const auto expect_refused = [&](const ProgramResult& result, const std::string& why) {
    EXPECT_EQ(result.exit_code, 65);
    EXPECT_EQ(result.error_line_count(), 1) << result.error;
    EXPECT_THAT(result.error, HasSubstr(why));
    EXPECT_FALSE(fs::exists(folder_.path() / "case"));
  };
  expect_refused(run(input, "case", "--geometry '" + table + "'"), "not finite");
  const ProgramResult missing = run(input, "case", "--geometry '" + (folder_ / "none.csv") + "'");
  EXPECT_EQ(missing.exit_code, 66);
  EXPECT_THAT(missing.error, HasSubstr("there is no geometry file"));
  fs::resize_file(file, fs::file_size(file) / 2);
  expect_refused(run(input, "case"), "ends within its pixels");
  expect_refused(run(input, "case", "--until reconstruction"), "nothing to reconstruct");
}

TEST_F(RotationalRuns, WhoseFramesAndVolumeDisagreeDetermineNothing) {
  const std::string input = make_run("xa", "--frames 60 --breathing 20");
  ASSERT_EQ(run(input, "case", "--until reconstruction").exit_code, 0);
  const json doubt = json_of(folder_.path() / "case/reconstruction/quality.json").at("doubt");
  ASSERT_TRUE(doubt.is_string());
  EXPECT_THAT(doubt.get<std::string>(), HasSubstr("Trust no diameter"));
}

TEST_F(RotationalRuns, AreInspectedForWhatTheyCanGive) {
  const std::string input = make_run("xa", "--frames 120 --mask-run");
  const ProgramResult text = run_program("inspect '" + input + "'");
  EXPECT_THAT(text.out,
              HasSubstr("makes a volume of: X-Ray Angiographic Image Storage, 120 frames, "
                        "with its mask run"));
  EXPECT_THAT(text.out, HasSubstr("expected: radii to about 0.03 mm"));  // pixels of 0.3 mm
  EXPECT_THAT(text.out, HasSubstr("usable by `angio run`: a rotational run"));
  EXPECT_THAT(text.out, Not(HasSubstr("refused")));
  EXPECT_EQ(text.exit_code, 0);
  const json told = json::parse(run_program("inspect --json '" + input + "'").out);
  EXPECT_EQ(told.at("reconstruction").at("frames"), 120);
  EXPECT_TRUE(told.at("reconstruction").at("subtracted"));
}

TEST_F(RotationalRuns, ShowTheLumenOnTheirFrames) {
  ASSERT_EQ(run(make_run("xa", "--frames 90"), "case", "--preset draft").exit_code, 0);
  const fs::path report = folder_.path() / "case/report";
  EXPECT_TRUE(fs::exists(report / "frames_sheet.png"));
  EXPECT_TRUE(fs::exists(report / "frame_8.png"));
  EXPECT_THAT(file_text(report / "index.html"), HasSubstr("X-ray frames"));
  const json shown = json_of(folder_.path() / "case/reconstruction/frames.json");
  EXPECT_EQ(shown.at("frames").size(), 8u);
  EXPECT_EQ(shown.at("frames").back().at("frame"), 90);
}

/// Also where it is the default of other formats.
TEST_F(RotationalRuns, HaveTheNoiseThatIsAskedFor) {
  const auto noise_of = [&](const std::string& name, const std::string& options) {
    EXPECT_EQ(run(make_run("xa_" + name, "--frames 60 --no-body " + options), name,
                  "--until reconstruction --set reconstruction.calibrate=false")
                  .exit_code,
              0);
    return json_of(folder_.path() / name / "reconstruction/quality.json")
        .at("noise_per_mm")
        .get<double>();
  };
  EXPECT_NEAR(noise_of("much", "--noise 0.1") / noise_of("little", "--noise 0.02"), 5.0, 1.0);
}

TEST_F(RotationalRuns, AreNotAStageOfOtherInputs) {
  ASSERT_EQ(run("phantom:concentric,length=20,spacing=0.4", "case").exit_code, 0);
  EXPECT_FALSE(json_of(folder_.path() / "case/run.json").at("stages").contains("reconstruction"));
  EXPECT_FALSE(fs::exists(folder_.path() / "case/reconstruction"));
}

}  // namespace
}  // namespace angio::pipeline

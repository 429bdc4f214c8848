#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/clinical_limits.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "meshing/meshing.hpp"
#include "pipeline/cli/recommend.hpp"
#include "pipeline/config/balloon_file.hpp"
#include "run_program.hpp"

namespace angio::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const TreatedLesion kLesion{{3.0, 10.0}, 0, 20.0};

ExitCode code_of(const CandidateRequest& request) {
  try {
    make_candidates(request, kLesion.size, {});
  } catch (const Error& error) {
    return error.exit_code();
  }
  return ExitCode::done;
}

TEST(Candidates, AreAtMostNineByDefaultAndCoverTheLesion) {
  for (const double diameter : {1.2, 1.6, 2.0, 3.0, 4.4, 8.0, 24.0})
    for (const double length : {1.0, 10.0, 22.0}) {
      const auto candidates = make_candidates({}, {diameter, length}, {});
      EXPECT_GE(candidates.size(), 3U);
      EXPECT_LE(candidates.size(), 9U);
      std::set<std::string> names;
      for (const Candidate& candidate : candidates) {
        names.insert(candidate.variant.name);
        EXPECT_GE(candidate.length_mm,
                  meshing::usual_balloon_length_mm(length, candidate.diameter_mm));
        EXPECT_EQ(candidate.diameter_mm, meshing::usual_balloon_diameter_mm(candidate.diameter_mm));
      }
      EXPECT_EQ(names.size(), candidates.size());
    }
}

TEST(Candidates, WithLengthsOrPressuresAreEveryCombination) {
  CandidateRequest request;
  request.diameters = {"3.5", "3"};
  request.lengths = {"12", "20"};
  request.pressures = {"nominal", "10", "rated", "8"};  // 8 is nominal
  const auto candidates = make_candidates(request, kLesion.size, {});
  EXPECT_EQ(candidates.size(), 12U);
  EXPECT_EQ(candidates[0].variant.name, "3x12mm-8atm");
  EXPECT_EQ(candidates[0].pressure, "nominal");
  EXPECT_EQ(candidates[1].pressure, "");
}

TEST(Candidates, OfTheCatalogueAreThoseBalloonsWhateverTheCaseHad) {
  const auto catalogue = balloon_catalogue();
  Config config;
  apply_balloon(config, simulation::find_balloon(catalogue, "nc-4.0"));
  CandidateRequest request;
  request.balloons = {"sc-3.0"};
  for (const bool is_named : {true, false}) {
    if (!is_named) request = {.diameters = {"3"}};
    for (const Candidate& candidate : make_candidates(request, kLesion.size, config)) {
      Config changed = config;
      for (const std::string& setting : candidate.variant.settings) apply_setting(changed, setting);
      EXPECT_EQ(changed.balloon.nominal_diameter_mm, 3.0);
      EXPECT_EQ(changed.balloon.length_mm, candidate.length_mm);
      EXPECT_EQ(changed.simulation.inflation.peak_pressure_atm, candidate.pressure_atm);
      EXPECT_EQ(changed.simulation.balloon.name, "pa12");
      EXPECT_EQ(changed.simulation.balloon.chart.empty(), !is_named);
      EXPECT_EQ(changed.simulation.inflation.rated_burst_atm, is_named ? 14.0 : 0.0);
    }
  }
}

TEST(Candidates, WrongValuesAreRefused) {
  EXPECT_EQ(code_of({.diameters = {"wide"}}), ExitCode::usage);
  EXPECT_EQ(code_of({.lengths = {"-3"}}), ExitCode::usage);
  EXPECT_EQ(code_of({.pressures = {"burst"}}), ExitCode::usage);
  EXPECT_EQ(code_of({.lengths = {"1000"}}), ExitCode::bad_config);
  EXPECT_THROW(make_candidates({.balloons = {"sc-3.1"}}, kLesion.size, {}), Error);
}

/// What a candidate would leave, with as many measures as the table has.
CandidateResult judged(const std::string& status, double residual, double ratio, double ffr,
                       double peak_atm, const std::string& vessel = "coronary",
                       double place_mm = 20.0, double widening = 1.0) {
  VariantRow row{{}, status, "", std::vector<double>(variant_measures().size(), kNotMeasured)};
  for (std::size_t m = 0; m < row.measures.size() && status == "done"; ++m) {
    const std::string column = variant_measures()[m].column;
    row.measures[m] = column == "residual_stenosis_percent" ? residual
                      : column == "balloon_to_artery_ratio" ? ratio
                      : column == "ffr_after"               ? ffr
                      : column == "widening_beside_lesion"  ? widening
                                                            : 10.0;
  }
  const json metrics = {
      {"lesion", {{"centerline_id", 0}, {"abscissa_mm", place_mm}}},
      {"balloon",
       {{"rated_burst_atm", 14.0}, {"peak_pressure_atm", peak_atm}, {"length_mm", 15.0}}},
      {"flow", {{"vessel", vessel}}}};
  return judge_candidate({"", 3.0, 15.0, peak_atm, "", {}}, row, metrics, kLesion);
}

TEST(Recommend, MissesEachLimitJustBehindIt) {
  using namespace limits;
  const auto limits_missed = [](const CandidateResult& result) {
    std::vector<std::string> keys;
    for (const Miss& miss : result.missed) keys.push_back(miss.limit);
    return keys;
  };
  const double residual = kMostResidualStenosisPercent, ratio = kMostBalloonToArteryRatio,
               ffr = kFlowLimitingFfr;
  EXPECT_THAT(limits_missed(judged("done", residual, ratio, ffr + 0.01, 14.0)), testing::IsEmpty());
  EXPECT_THAT(limits_missed(judged("done", residual + 1.0, ratio, ffr + 0.01, 14.0)),
              testing::ElementsAre("residual_stenosis_percent"));
  EXPECT_THAT(limits_missed(judged("done", residual, ratio + 0.01, ffr + 0.01, 14.0)),
              testing::ElementsAre("balloon_to_artery_ratio"));
  EXPECT_THAT(limits_missed(judged("done", residual, ratio, ffr, 14.0)),
              testing::ElementsAre("ffr_after"));
  EXPECT_THAT(limits_missed(judged("done", residual, ratio, ffr + 0.01, 14.1)),
              testing::ElementsAre("rated_burst_atm"));
  const auto widened = [&](double by) {
    return limits_missed(judged("done", residual, ratio, ffr + 0.01, 14.0, "coronary", 20.0, by));
  };
  EXPECT_THAT(widened(kMostWideningBeside), testing::IsEmpty());
  EXPECT_THAT(widened(kMostWideningBeside + 0.01), testing::ElementsAre("widening_beside_lesion"));
  const CandidateResult other = judged("done", residual, ratio, ffr, 14.0, "other");
  EXPECT_THAT(other.missed, testing::IsEmpty());
  EXPECT_EQ(other.notes.size(), 1U);
}

TEST(Recommend, NothingIsToldOfAnotherLesionOrOfWhatIsNotDetermined) {
  EXPECT_EQ(judged("done", 20, 1, 0.9, 8, "coronary", 20.1).standing.certainty,
            Certainty::determined);
  EXPECT_EQ(judged("done", 20, 1, 0.9, 8, "coronary", 40).standing.certainty,
            Certainty::not_determined);
  for (const char* status : {"failed", "stale", "no_lesion"})
    EXPECT_EQ(judged(status, 20, 1, 0.9, 8).standing.certainty, Certainty::failed) << status;
}

TEST(Recommend, SaysWhereNoCandidateMeetsAllLimits) {
  std::vector<CandidateResult> results = {
      judged("failed", 0, 0, 0, 8), judged("done", 40, 1.2, 0.9, 8), judged("done", 35, 1, 0.9, 8)};
  rank_results(results);
  EXPECT_EQ(results[0].missed.size(), 1U);
  EXPECT_EQ(results[2].row.status, "failed");
  EXPECT_THAT(recommendation_words(results), testing::HasSubstr("No candidate meets all limits"));
  EXPECT_THAT(recommendation_words(results), testing::HasSubstr("Front: of candidates"));
  std::istringstream table(recommendation_table(results));
  const auto columns_of = [](const std::string& line) {
    std::istringstream words(line);
    return std::distance(std::istream_iterator<std::string>(words), {});
  };
  std::string header, row;
  std::getline(table, header);
  while (std::getline(table, row)) EXPECT_EQ(columns_of(row), columns_of(header)) << row;
  results = {judged("failed", 0, 0, 0, 8)};
  rank_results(results);
  EXPECT_THAT(recommendation_words(results), testing::HasSubstr("determined"));
}

TEST(Recommend, RanksWhatItHasRunAndGoesOn) {
  const test::CommandFolder folder;
  const std::string base = folder / "base", out = folder / "out";
  ASSERT_EQ(test::run_program("run 'phantom:concentric,length=24,stenosis=50,noise=0' -o '" + base +
                              "' --until meshing --preset draft --threads 1 --set "
                              "inflation.inflate_s=0.4 inflation.hold_s=0.2 "
                              "inflation.deflate_s=0.4 volume.fill=false "
                              "wall.model=shape_matching")
                .exit_code,
            0);
  const std::string command = "recommend --diameters 2.5,3 --lengths 8 --pressures nominal '" +
                              base + "' --threads 1 -o '" + out + "'";
  const test::ProgramResult result = test::run_program(command);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, testing::HasSubstr("not medical advice"));
  EXPECT_TRUE(fs::exists(fs::path(out) / "recommendation.svg"));
  const std::string text = test::file_text(fs::path(out) / "recommendation.json");
  const json found = json::parse(text);
  ASSERT_EQ(found["candidates"].size(), 2U);
  for (const json& candidate : found["candidates"]) EXPECT_EQ(candidate["status"], "done");
  EXPECT_LE(found["candidates"][0]["rank"], found["candidates"][1]["rank"]);
  const auto table = formats::read_csv_table(fs::path(out) / "recommendation.csv");
  EXPECT_EQ(table.rows.size(), 2U);

  const fs::path made = fs::path(out) / "3x8mm-8atm/simulation/lumen_after.vtp";
  const auto then = fs::last_write_time(made);
  ASSERT_EQ(test::run_program(command).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(made), then);
  EXPECT_EQ(test::file_text(fs::path(out) / "recommendation.json"), text);
}

TEST(Recommend, NeedsACaseThatIsMeshed) {
  const test::CommandFolder folder;
  EXPECT_EQ(test::run_program("recommend '" + folder / "nothing" + "'").exit_code, 66);
  ASSERT_EQ(test::run_program("run 'phantom:straight,length=20,noise=0' -o '" + folder / "base" +
                              "' --preset draft --until segmentation")
                .exit_code,
            0);
  const auto result = test::run_program("recommend '" + folder / "base" + "'");
  EXPECT_EQ(result.exit_code, 65);
  EXPECT_EQ(result.error_line_count(), 1) << result.error;
}

}  // namespace
}  // namespace angio::pipeline

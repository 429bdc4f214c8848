#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "pipeline/cli/batch_memory.hpp"
#include "pipeline/cli/batch_outcome.hpp"
#include "pipeline/cli/batch_page.hpp"
#include "pipeline/cli/bids_command.hpp"
#include "run_program.hpp"

namespace angio::pipeline {
namespace {
namespace fs = std::filesystem;

std::vector<std::string> names_of(const std::vector<BatchCase>& cases) {
  std::vector<std::string> names;
  for (const BatchCase& one : cases) names.push_back(one.name);
  return names;
}

class BidsDataset : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* file :
         {"sub-02/anat/sub-02_angio.nii.gz", "sub-01/ses-a/anat/sub-01_ses-a_angio.nii",
          "sub-01/ses-b/anat/sub-01_ses-b_run-1_angio.nii.gz",
          "sub-01/ses-b/anat/sub-01_ses-b_T1w.nii", "derivatives/sub-09/anat/sub-09_angio.nii",
          "sub-03/anat/sub-03_T1w.nii"})
      write_text_atomically(folder_.path() / file, "x");
  }
  test::CommandFolder folder_;
};

TEST_F(BidsDataset, HasACaseForEachAngiogram) {
  const auto cases = bids_cases(folder_.path(), "angio", {});
  EXPECT_EQ(names_of(cases),
            (std::vector<std::string>{"sub-01_ses-a", "sub-01_ses-b_run-1", "sub-02"}));
  EXPECT_EQ(cases[2].input, folder_ / "sub-02/anat/sub-02_angio.nii.gz");
  EXPECT_EQ(names_of(bids_cases(folder_.path(), "T1w", {})),
            (std::vector<std::string>{"sub-01_ses-b", "sub-03"}));
}

TEST_F(BidsDataset, ParticipantsAreChosenByTheirLabels) {
  EXPECT_EQ(names_of(bids_cases(folder_.path(), "angio", {"02"})),
            (std::vector<std::string>{"sub-02"}));
  EXPECT_EQ(names_of(bids_cases(folder_.path(), "angio", {"sub-02"})),
            (std::vector<std::string>{"sub-02"}));
  EXPECT_THROW(bids_cases(folder_.path(), "angio", {"04"}), InputError);
  EXPECT_THROW(bids_cases(folder_.path(), "angio", {"03"}), InputError);  // it has no angiogram
  EXPECT_THROW(bids_cases(folder_.path() / "nowhere", "angio", {}), InputError);
}

TEST(MemoryBudget, LetsTheFirstCaseInAndNoMoreThanFit) {
  MemoryBudget budget(100);
  EXPECT_TRUE(budget.has_room_for(1000));  // it may yet do with less
  budget.take(60);
  EXPECT_TRUE(budget.has_room_for(40));
  EXPECT_FALSE(budget.has_room_for(41));
  budget.give_back(60);
  EXPECT_TRUE(budget.has_room_for(1000));
}

TEST(MemoryTaken, IsThatOfTheGreediestStage) {
  test::CommandFolder folder;
  EXPECT_EQ(memory_taken(folder.path()), 0U);
  write_text_atomically(
      folder / "run.json",
      R"({"stages": {"a": {"peak_memory_mib": 10}, "b": {"peak_memory_mib": 300.5}}})");
  EXPECT_EQ(memory_taken(folder.path()), std::uint64_t(300.5 * 1024 * 1024));
  write_text_atomically(folder / "run.json", "[[[[");
  EXPECT_EQ(memory_taken(folder.path()), 0U);
}

TEST(CompletionFile, IsThereIfAndOnlyIfTheCaseIsDone) {
  test::CommandFolder folder;
  BatchCase one;
  one.name = "A";
  const fs::path done = folder.path() / "logs" / "A.done";
  write_outcome(folder.path(), one, {"started", -1, 1, ""});
  EXPECT_FALSE(fs::exists(done));
  write_outcome(folder.path(), one, {"done", 0, 1, ""});
  EXPECT_TRUE(fs::exists(done));
  write_outcome(folder.path(), one, {"failed", 65, 2, "x"});
  EXPECT_FALSE(fs::exists(done));
}

std::vector<SummaryCase> cases_with_recoil(const std::vector<double>& values) {
  std::vector<SummaryCase> cases;
  for (const double value : values) {
    SummaryCase one;
    one.name = "case" + std::to_string(cases.size() + 1);
    one.outcome = {"done", 0, 1, ""};
    one.case_status = "done";
    one.metrics = {{"result", {{"recoil_percent", value}}}};
    cases.push_back(one);
  }
  return cases;
}

const SummaryMeasure& recoil() {
  for (const SummaryMeasure& measure : summary_measures())
    if (std::string(measure.pointer) == "/result/recoil_percent") return measure;
  throw InternalError("there is no such measure");
}

TEST(SpreadFigure, HasEveryCaseInOneBar) {
  std::vector<double> values;
  for (int v = 0; v < 40; ++v) values.push_back(20.0 + 0.25 * v);
  const std::string figure = spread_figure(cases_with_recoil(values), recoil());
  int sum = 0;
  const std::regex count("<title>([0-9]+)</title>");
  for (auto at = std::sregex_iterator(figure.begin(), figure.end(), count);
       at != std::sregex_iterator(); ++at)
    sum += std::stoi((*at)[1]);
  EXPECT_EQ(sum, 40);
  EXPECT_THAT(figure, testing::HasSubstr("40 cases, median 24.9"));  // (24.75 + 25) / 2
}

TEST(SpreadFigure, NeedsTwoCasesAndTakesEqualOnes) {
  EXPECT_EQ(spread_figure(cases_with_recoil({20.0}), recoil()), "");
  EXPECT_THAT(spread_figure(cases_with_recoil({20.0, 20.0}), recoil()),
              testing::HasSubstr("2 cases, median 20"));
  EXPECT_THAT(spread_figure(cases_with_recoil(std::vector<double>(8, 20.0)), recoil()),
              testing::HasSubstr("quartiles 20, 20"));
}

TEST(SpreadFigure, OfFewCasesIsADotForEachWithItsName) {
  const std::string figure = spread_figure(cases_with_recoil({20.0, 20.0, 26.0, 23.0}), recoil());
  EXPECT_EQ(figure.find("<rect x="), std::string::npos);
  std::map<std::string, std::pair<double, double>> dots;
  const std::regex dot("<circle cx=\"([0-9.]+)\" cy=\"([0-9.]+)\"[^>]*><title>(case[0-9]): ");
  for (auto at = std::sregex_iterator(figure.begin(), figure.end(), dot);
       at != std::sregex_iterator(); ++at)
    dots[(*at)[3]] = {std::stod((*at)[1]), std::stod((*at)[2])};
  ASSERT_EQ(dots.size(), 4U) << figure;
  EXPECT_EQ(dots["case1"].first, dots["case2"].first);
  EXPECT_NE(dots["case1"].second, dots["case2"].second);  // above each other
  EXPECT_NEAR(dots["case4"].first, 0.5 * (dots["case1"].first + dots["case3"].first), 0.2);
}

TEST(SpreadFigure, LeavesOutWhatATrialBalloonDidWhereThereIsNoStenosis) {
  auto cases = cases_with_recoil({20.0, 20.0, 26.0});
  cases[2].case_status = "no_lesion";
  EXPECT_THAT(spread_figure(cases, recoil()), testing::HasSubstr("2 cases, median 20"));
}

TEST(SummaryTable, HasNumbersWordsAndTruthValuesAsTheyAre) {
  test::CommandFolder folder;
  write_text_atomically(folder / "A/metrics.json",
                        R"({"status": "done", "mesh": {"lumen_triangles": 14488, "volume": 0.125},
                            "flow": {"vessel": "other", "reason": null},
                            "lesion": {"mld_below_resolution": true, "mld_mm": 1.2345678},
                            "simulation": {"device": "a processor", "wall_s": 3.5}})");
  BatchCase one;
  one.name = "A";
  write_summary(folder.path(), folder.path() / "summary.csv", {one}, {{"done", 0, 1, ""}});
  const std::string table = read_text(folder.path() / "summary.csv");
  for (const char* cell : {"14488", "0.125", "other", "true", "1.23457", "flow.vessel"})
    EXPECT_THAT(table, testing::HasSubstr(cell));
  for (const char* cell : {"a processor", "3.5", "flow.reason"})
    EXPECT_THAT(table, testing::Not(testing::HasSubstr(cell)));
}

TEST(SummaryPage, MarksWhatTheScanDoesNotResolve) {
  test::CommandFolder folder;
  auto cases = cases_with_recoil({20.0});
  cases[0].metrics["lesion"] = {{"mld_below_resolution", true},
                                {"mld_mm", 0.2153},
                                {"resolution_mm", 0.3},
                                {"diameter_stenosis_percent", 92.82},
                                {"stenosis_at_least_percent", 90.0}};
  const std::string page = summary_page(folder.path(), cases);
  EXPECT_THAT(page, testing::HasSubstr(">&lt; 0.30<"));
  EXPECT_THAT(page, testing::HasSubstr(">≥ 90<"));
  EXPECT_THAT(page, testing::Not(testing::HasSubstr("0.2153")));
}

TEST(SummaryPage, HoldsWhatPeopleAndFilesSayAsText) {
  test::CommandFolder folder;
  auto cases = cases_with_recoil({20.0, 21.0});
  cases[0].outcome = {"failed", 65, 1, ""};
  cases[0].reason = "<script>alert(1)</script>\" onload=\"x";
  cases[0].warnings = {"<img src=x>\"'"};
  for (const std::string& page :
       {summary_page(folder.path(), cases), quality_page(folder.path(), cases)}) {
    EXPECT_EQ(page.find("<script>alert"), std::string::npos);
    EXPECT_EQ(page.find("onload=\"x"), std::string::npos);
    EXPECT_EQ(page.find("<img src=x"), std::string::npos);
    EXPECT_THAT(page, testing::HasSubstr("&lt;script&gt;alert(1)"));
  }
}

TEST(QualityPage, LinksTheReportsThatAreThere) {
  const test::TemporaryFolder folder;
  write_text_atomically(folder / "good/report/index.html", "report");
  std::vector<SummaryCase> cases(2);
  cases[0].name = "good";
  cases[1].name = "bad";
  const std::string page = quality_page(folder.path(), cases);
  EXPECT_NE(page.find("href=\"good/report/index.html\""), std::string::npos);
  EXPECT_EQ(page.find("href=\"bad/report/index.html\""), std::string::npos);
  EXPECT_NE(page.find("bad"), std::string::npos);
}

TEST(SummaryPage, LinksWhatIsThere) {
  test::CommandFolder folder;
  write_text_atomically(folder / "case1/report/index.html", "x");
  write_text_atomically(folder / "case1/report/tree.png", "x");
  const std::string page = summary_page(folder.path(), cases_with_recoil({20.0, 21.0}));
  EXPECT_THAT(page, testing::HasSubstr("href=\"case1/report/index.html\""));
  EXPECT_THAT(page, testing::HasSubstr("src=\"case1/report/tree.png\""));
  EXPECT_THAT(page, testing::Not(testing::HasSubstr("case2/report")));
}

}  // namespace
}  // namespace angio::pipeline

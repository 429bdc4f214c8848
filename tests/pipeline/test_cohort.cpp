// A batch as a group with many cases runs it: in parts, again, and after failures.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "pipeline/case/case_folder.hpp"
#include "pipeline/cli/batch.hpp"
#include "run_program.hpp"

namespace angio::test {
namespace {

namespace fs = std::filesystem;
using pipeline::BatchCase;

const std::string kPhantom = "\"phantom:unilateral,length=10,stenosis=50,noise=0\"";
const std::string kQuick =
    " --preset draft --threads 1 --set balloon.ring_count=6 balloon.ring_vertex_count=8 "
    "simulation.sweeps=20 mesh.edges_per_circumference=8 inflation.inflate_s=0.1 "
    "inflation.hold_s=0 inflation.deflate_s=0.1 inflation.rest_s=0 volume.fill=false ";

/// A folder with a manifest m.csv, whose rows end at once, or are a small phantom.
class Cohort : public testing::Test {
 protected:
  Cohort() { write_text_atomically(folder_ / "broken.nrrd", "NRRD0004\n# cut off\n"); }
  void write_manifest(const std::string& rows) const {
    write_text_atomically(folder_ / "m.csv", "case,input,balloon.length_mm\n" + rows);
  }
  [[nodiscard]] ProgramResult batch(const std::string& options,
                                    const std::string& output = "out") const {
    return run_program("batch '" + folder_ / "m.csv" + "' -o '" + folder_ / output + "' " +
                       options);
  }
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }
  /// Each file with its content and the time of its last change.
  [[nodiscard]] std::map<std::string, std::pair<std::string, fs::file_time_type>> files() const {
    std::map<std::string, std::pair<std::string, fs::file_time_type>> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
      found[entry.path()] = {entry.is_regular_file() ? file_text(entry.path()) : "",
                             fs::last_write_time(entry.path())};
    return found;
  }
  /// A column of a summary by the cases' names.
  [[nodiscard]] std::map<std::string, std::string> column(const std::string& summary,
                                                          const std::string& name) const {
    const formats::CsvTable table = formats::read_csv_table(path(summary));
    std::map<std::string, std::string> cells;
    for (std::size_t r = 0; r < table.rows.size(); ++r)
      cells[table.texts("case")[r]] = table.texts(name)[r];
    return cells;
  }

  CommandFolder folder_;
};

std::vector<std::string> names_of(const std::vector<BatchCase>& cases) {
  std::vector<std::string> names;
  for (const BatchCase& one : cases) names.push_back(one.name);
  return names;
}

TEST(Shards, AreDisjointAndTogetherAllRows) {
  for (int row_count = 0; row_count < 12; ++row_count) {
    std::vector<BatchCase> cases;
    for (int r = 0; r < row_count; ++r)
      cases.emplace_back().name = "case" + std::to_string(100 + r);
    for (int count = 1; count < 15; ++count) {
      std::vector<std::string> together;
      for (int number = count; number >= 1; --number) {
        const auto names = names_of(pipeline::rows_of_shard(cases, {number, count}));
        EXPECT_LE(std::abs(int(names.size()) * count - row_count), count);  // equal shares
        together.insert(together.end(), names.begin(), names.end());
      }
      std::sort(together.begin(), together.end());
      EXPECT_EQ(together, names_of(cases)) << count;  // each row once
    }
  }
}

TEST(Shards, AreNamedByNumberAndCount) {
  EXPECT_EQ(pipeline::parse_shard("2/5").number, 2);
  EXPECT_EQ(pipeline::parse_shard("2/5").count, 5);
  for (const char* text : {"", "2", "0/5", "6/5", "1/0", "a/b", "1/2/3", "-1/2", "1/9999999"})
    EXPECT_THROW(pipeline::parse_shard(text), Error) << text;
}

TEST_F(Cohort, TwoBatchesOfAllRowsKeepOutOfOneFolderAndShardsDoNot) {
  write_manifest("A,broken.nrrd,\n");
  fs::create_directories(path("out/logs"));
  const auto code_beside = [&](pipeline::FolderLock::Kind kind, const std::string& options) {
    const pipeline::FolderLock other(path("out/logs"), kind);
    return batch(options).exit_code;
  };
  using Kind = pipeline::FolderLock::Kind;
  EXPECT_EQ(code_beside(Kind::own, ""), 73);
  EXPECT_EQ(code_beside(Kind::shared, ""), 73);
  EXPECT_FALSE(fs::exists(path("out/logs/A.json")));
  EXPECT_EQ(code_beside(Kind::own, "--shard 1/2"), 73);
  EXPECT_EQ(code_beside(Kind::shared, "--shard 1/2"), 2);
  EXPECT_EQ(batch("").exit_code, 2);
}

TEST_F(Cohort, ShardsInAnyOrderSumUpToTheWholeBatch) {
  write_manifest("A,broken.nrrd,\nB,broken.nrrd,5\nC,broken.nrrd,\nD,broken.nrrd,\n");
  for (const char* shard : {"3/3", "1/3", "2/3"})
    EXPECT_EQ(batch(std::string("--shard ") + shard).exit_code, 2) << shard;
  EXPECT_EQ(column("out/summary-1-of-3.csv", "status").size(), 2U);
  EXPECT_EQ(column("out/summary-2-of-3.csv", "status").size(), 1U);
  EXPECT_FALSE(fs::exists(path("out/summary.csv")));
  fs::remove(path("broken.nrrd"));  // lies on the other machines
  EXPECT_EQ(batch("--summary-only").exit_code, 2);
  write_text_atomically(folder_ / "broken.nrrd", "NRRD0004\n# cut off\n");
  EXPECT_EQ(batch("", "whole").exit_code, 2);
  EXPECT_EQ(file_text(path("out/summary.csv")), file_text(path("whole/summary.csv")));
}

TEST_F(Cohort, OnlyFailedLeavesAllOthersAlone) {
  write_manifest("C,broken.nrrd,\n");
  EXPECT_EQ(batch("").exit_code, 2);
  write_text_atomically(folder_ / "out/A/metrics.json", R"({"status": "done"})");
  write_manifest("A,broken.nrrd,\nC,broken.nrrd,\nN,broken.nrrd,\n");
  const std::string before = file_text(path("out/A/metrics.json"));
  EXPECT_EQ(batch("--only-failed --retry 1").exit_code, 2);
  // The input is damaged (exit code 65): no further try mends it, whatever --retry says.
  EXPECT_EQ(column("out/summary.csv", "tries"),
            (std::map<std::string, std::string>{{"A", "0"}, {"C", "1"}, {"N", "0"}}));
  EXPECT_EQ(column("out/summary.csv", "status"),
            (std::map<std::string, std::string>{{"A", "done"}, {"C", "failed"}, {"N", "not run"}}));
  EXPECT_EQ(file_text(path("out/A/metrics.json")), before);
  EXPECT_FALSE(fs::exists(path("out/N")));
  EXPECT_FALSE(fs::exists(path("out/logs/N.log")));
}

TEST_F(Cohort, ADryRunSaysWhatARunDoesAndChangesNothing) {
  write_manifest("A," + kPhantom + ",3\nB,broken.nrrd,\n");
  EXPECT_EQ(batch(kQuick).exit_code, 2);
  write_manifest("A," + kPhantom + ",3\nB,broken.nrrd,\nN,broken.nrrd,\n");
  const auto before = files();
  const auto plan = [&](const std::string& options) {
    const ProgramResult result = batch("--dry-run" + kQuick + options);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    std::map<std::string, std::string> actions;
    std::istringstream lines(result.out);
    for (std::string name, action, reason; lines >> name >> action && std::getline(lines, reason);)
      actions[name] = action;
    return actions;
  };
  using Plan = std::map<std::string, std::string>;
  EXPECT_EQ(plan("--resume"), (Plan{{"A", "skip"}, {"B", "run"}, {"N", "run"}}));
  EXPECT_EQ(plan("--only-failed"), (Plan{{"A", "skip"}, {"B", "run"}, {"N", "skip"}}));
  EXPECT_EQ(plan("--shard 2/2"), (Plan{{"B", "run"}}));
  write_manifest("A," + kPhantom + ",2\n");
  EXPECT_EQ(plan("--resume"), (Plan{{"A", "resume"}}));
  EXPECT_EQ(batch("--dry-run", "elsewhere").exit_code, 0);
  auto after = files();
  after[folder_ / "m.csv"] = before.at(folder_ / "m.csv");
  EXPECT_TRUE(after == before);
}

TEST_F(Cohort, ACaseWhoseNumbersWereDamagedIsMadeAgain) {
  write_manifest("A," + kPhantom + ",3\n");
  EXPECT_EQ(batch(kQuick).exit_code, 0);
  const std::string numbers = file_text(path("out/A/metrics.json")),
                    summary = file_text(path("out/summary.csv"));
  for (const std::string& damage : {numbers + "x", std::string("[]"), std::string()}) {
    write_text_atomically(path("out/A/metrics.json"), damage);
    EXPECT_EQ(batch("--summary-only" + kQuick).exit_code, 2) << "it is not done";
    EXPECT_TRUE(nlohmann::json::accept(file_text(path("out/summary.json")))) << damage;
    EXPECT_EQ(batch("--resume" + kQuick).exit_code, 0);
    EXPECT_EQ(file_text(path("out/A/metrics.json")), numbers);
    EXPECT_TRUE(nlohmann::json::accept(file_text(path("out/summary.json"))));
  }
}

TEST_F(Cohort, AFolderThatIsNotItsOwnIsNeverReplaced) {
  write_manifest("A," + kPhantom + ",3\n");
  fs::create_directories(path("out/A"));
  write_text_atomically(path("out/A/thesis.txt"), "mine");
  for (const char* again : {"", "--resume", "--only-failed", "--resume --retry 1"}) {
    EXPECT_EQ(batch(again + kQuick).exit_code, 2) << again;
    EXPECT_EQ(file_text(path("out/A/thesis.txt")), "mine");
    EXPECT_FALSE(fs::exists(path("out/A/run.json"))) << again;
  }
}

TEST_F(Cohort, AMinimalCaseIsDoneUntilItsRowChanges) {
  write_manifest("A," + kPhantom + ",3\n");
  EXPECT_EQ(batch("--keep minimal" + kQuick).exit_code, 0);
  for (const char* file : {"report/index.html", "metrics.json", "centerline/centerlines.vtp",
                           "centerline/lesions.json", "simulation/lumen_profile.csv"})
    EXPECT_TRUE(fs::exists(path("out/A") / file)) << file;
  for (const char* bulky : {"segmentation", "meshing/lumen.vtp", "simulation/frames"})
    EXPECT_FALSE(fs::exists(path("out/A") / bulky)) << bulky;
  const std::string summary = file_text(path("out/summary.csv"));
  EXPECT_EQ(batch("--summary-only").exit_code, 0);
  EXPECT_EQ(file_text(path("out/summary.csv")), summary);

  const std::string record = file_text(path("out/A/run.json"));
  for (const char* again : {"--resume", "--resume --keep minimal", "--keep minimal"}) {
    EXPECT_EQ(batch(again + kQuick).exit_code, 0) << again;
    EXPECT_EQ(file_text(path("out/A/run.json")), record) << again;
  }
  const ProgramResult report = run_program("report '" + folder_ / "out/A" + "'");
  EXPECT_EQ(report.exit_code, 66);
  EXPECT_EQ(report.error_line_count(), 1) << report.error;

  write_manifest("A," + kPhantom + ",2\n");
  EXPECT_EQ(batch("--resume --keep minimal" + kQuick).exit_code, 0);
  EXPECT_NE(file_text(path("out/A/run.json")), record);
  EXPECT_NE(file_text(path("out/A/metrics.json")).find("\"length_mm\": 2.0"), std::string::npos);
  EXPECT_FALSE(fs::exists(path("out/A/segmentation")));
}

}  // namespace
}  // namespace angio::test

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "pipeline/cli/verify_case.hpp"
#include "run_program.hpp"

namespace angio::pipeline {
namespace {

namespace fs = std::filesystem;

const std::string kSmallRun =
    "run phantom:unilateral,length=10,stenosis=50,noise=0 --preset draft --quiet --threads 1 --set "
    "balloon.length_mm=3 balloon.ring_count=6 balloon.ring_vertex_count=8 simulation.sweeps=20 "
    "mesh.edges_per_circumference=8 inflation.inflate_s=0.1 inflation.hold_s=0 "
    "inflation.deflate_s=0.1 inflation.rest_s=0 volume.fill=false ";

std::map<std::string, std::string> content_of(const fs::path& folder) {
  std::map<std::string, std::string> content;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      content[fs::relative(entry.path(), folder)] = test::file_text(entry.path());
  return content;
}

/// Writes in place, as a broken disk or an editor does.
void overwrite(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::vector<std::string> found_in(const fs::path& folder) {
  std::vector<std::string> found;
  try {
    for (const Finding& finding : verify_case(CaseFolder(folder)).findings)
      found.push_back(finding.kind + " " + finding.place);
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::bad_data);
    found.emplace_back("changed run.json");
  }
  return found;
}

bool holds(const std::vector<std::string>& found, const std::string& one) {
  return std::find(found.begin(), found.end(), one) != found.end();
}

TEST(Verify, FindsEveryChangeAndNothingElse) {
  const test::CommandFolder folder;
  ASSERT_EQ(test::run_program(kSmallRun + "-o '" + folder / "first" + "'").exit_code, 0);
  const fs::path root = folder.path() / "elsewhere";
  fs::rename(folder.path() / "first", root);
  EXPECT_EQ(found_in(root), std::vector<std::string>{});  // where it lies makes no difference

  const auto content = content_of(root);
  EXPECT_GT(content.size(), 40U);
  for (const auto& [file, text] : content) {
    std::string flipped = text;
    flipped[text.size() / 2] = char(flipped[text.size() / 2] ^ 1);
    overwrite(root / file, flipped);
    EXPECT_TRUE(holds(found_in(root), "changed " + file)) << file;
    fs::remove(root / file);
    if (file != "run.json") {
      EXPECT_TRUE(holds(found_in(root), "missing " + file)) << file;
    }
    overwrite(root / file, text);
  }
  const std::string record = content.at("run.json");
  for (std::size_t at = 0; at < record.size(); at += 499) {
    std::string flipped = record;
    flipped[at] = char(flipped[at] ^ 1);
    overwrite(root / "run.json", flipped);
    EXPECT_TRUE(holds(found_in(root), "changed run.json")) << at;
  }
  overwrite(root / "run.json", record);
  EXPECT_EQ(found_in(root), std::vector<std::string>{});
  EXPECT_EQ(content_of(root), content);  // it has written nothing

  // A setting of one stage: it, and all that was made from it.
  std::string settings = content.at("case.toml");
  settings.replace(settings.find("length_mm = 3.0"), 15, "length_mm = 4.0");
  overwrite(root / "case.toml", settings);
  EXPECT_EQ(found_in(root), (std::vector<std::string>{"changed case.toml", "stale meshing",
                                                      "stale simulation", "stale report"}));
  overwrite(root / "case.toml", content.at("case.toml"));

  const CaseFolder case_folder(root);
  RunRecord unfinished = case_folder.read_record();
  unfinished.stages[Stage::report].status = "interrupted";
  case_folder.write_record(unfinished);
  EXPECT_EQ(found_in(root), std::vector<std::string>{"unfinished report"});

  // Of another build the settings are not judged, the files are.
  RunRecord foreign = case_folder.read_record();
  foreign.stages[Stage::report].status = "done";
  for (auto& [stage, entry] : foreign.stages) {
    entry.key = "of another program";
    entry.build = "0.0.1 (abc)";
  }
  case_folder.write_record(foreign);
  EXPECT_EQ(found_in(root), std::vector<std::string>{});
  EXPECT_EQ(verify_case(case_folder).notes.size(), 1U);
}

TEST(Verify, TakesAMinimalCaseAsItWasLeft) {
  const test::CommandFolder folder;
  const std::string output = "-o '" + folder / "c" + "'";
  ASSERT_EQ(test::run_program(kSmallRun + output + " --keep minimal").exit_code, 0);
  const test::ProgramResult clean = test::run_program("verify --json '" + folder / "c" + "'");
  EXPECT_EQ(clean.exit_code, 0) << clean.error;
  EXPECT_EQ(nlohmann::json::parse(clean.out).at("clean"), true);
  fs::remove(folder.path() / "c/simulation/timeseries.csv");
  const test::ProgramResult result = test::run_program("verify '" + folder / "c" + "'");
  EXPECT_EQ(result.exit_code, 65);
  EXPECT_EQ(result.error_line_count(), 1);
  EXPECT_NE(result.out.find("missing    simulation/timeseries.csv"), std::string::npos);
}

TEST(Verify, RefusesWhatIsNoCase) {
  const test::CommandFolder folder;
  EXPECT_EQ(test::run_program("verify '" + folder / "nothing" + "'").exit_code, 66);
  write_text_atomically(folder / "c/run.json", R"({"stages": {"mishing": {}}})");
  EXPECT_EQ(test::run_program("verify '" + folder / "c" + "'").exit_code, 65);
}

}  // namespace
}  // namespace angio::pipeline

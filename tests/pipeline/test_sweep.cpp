#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "pipeline/cli/sweep.hpp"
#include "run_program.hpp"

namespace angio::pipeline {
namespace {

namespace fs = std::filesystem;

template <class Action>
ExitCode code_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.exit_code();
  }
  return ExitCode::done;
}

TEST(Sweep, AnAxisIsAKeyAndItsValues) {
  const SweepAxis axis = parse_axis("balloon.length_mm=8,12.5,20");
  EXPECT_EQ(axis.key, "balloon.length_mm");
  EXPECT_EQ(axis.values, (std::vector<std::string>{"8", "12.5", "20"}));
  for (const char* text : {"balloon.length_mm", "=1,2", "a.b=", "a.b=1,", "a.b=1,,2", "a.b=1,1"})
    EXPECT_EQ(code_of([&] { parse_axis(text); }), ExitCode::usage) << text;
}

TEST(Sweep, VariantsAreAllCombinationsWithNamesOfTheirOwn) {
  const auto variants = make_variants(
      {parse_axis("balloon.length_mm=8,12"), parse_axis("inflation.peak_pressure_atm=6,8,10")}, {});
  ASSERT_EQ(variants.size(), 6U);
  std::set<std::string> names;
  std::set<std::vector<std::string>> settings;
  for (const BatchCase& variant : variants) {
    names.insert(variant.name);
    settings.insert(variant.settings);
  }
  EXPECT_EQ(names.size(), 6U);
  EXPECT_EQ(settings.size(), 6U);
  EXPECT_EQ(variants[0].settings,
            (std::vector<std::string>{"balloon.length_mm=8", "inflation.peak_pressure_atm=6"}));
}

TEST(Sweep, FaultsNameWhatWasTypedAndNoOtherOption) {
  for (const auto& [text, expected] :
       {std::pair{"balloon.lenght_mm=8,12", "balloon.lenght_mm to give the values 8,12"},
        {"balloon.length_mm=8,long", "balloon.length_mm=long"},
        {"balloon.length_mm=8,-4", "balloon.length_mm=-4"},
        {"balloon.length_mm=8,,4", "balloon.length_mm=8,,4"}}) {
    try {
      make_variants({parse_axis(text)}, {});
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find("--set"), std::string::npos) << error.what();
    }
  }
}

TEST(Sweep, WrongKeysAndValuesAreRefusedBeforeAnythingRuns) {
  for (const char* text :
       {"balloon.lenght_mm=8,12", "balloon.length_mm=8,long", "balloon.length_mm=8,1e9"})
    EXPECT_EQ(code_of([&] { make_variants({parse_axis(text)}, {}); }), ExitCode::bad_config)
        << text;
  const SweepAxis axis = parse_axis("balloon.length_mm=8");
  EXPECT_EQ(code_of([&] { make_variants({axis, axis}, {}); }), ExitCode::bad_config);
}

TEST(Sweep, AVariantWithoutAResultHasNoNumbers) {
  const test::CommandFolder folder;
  const BatchCase variant{"v", "", {"balloon.length_mm=8"}, "", "", ""};
  EXPECT_EQ(read_variant(folder.path(), variant).status, "failed");
  for (const char* status : {"done", "not_determined", "failed"}) {
    write_text_atomically(folder.path() / "v/metrics.json",
                          nlohmann::json{{"status", status}, {"result", {{"mld_mm", 2.5}}}}.dump());
    const VariantRow row = read_variant(folder.path(), variant);
    EXPECT_EQ(row.status, status);
    EXPECT_EQ(std::isnan(row.measures[1]), status != std::string("done")) << status;
  }
}

TEST(Sweep, ItsChartsBeginWithTheResultAndLeaveOutWhatDoesNotChange) {
  const test::CommandFolder folder;
  const std::vector<SweepAxis> axes = {parse_axis("inflation.peak_pressure_atm=9,6,12.5"),
                                       parse_axis("balloon.length_mm=10,14")};
  std::vector<VariantRow> rows;
  for (const BatchCase& variant : make_variants(axes, {})) {
    const double place = double(rows.size());
    rows.push_back({variant, "done", "", std::vector<double>(variant_measures().size(), place)});
    rows.back().measures[0] = 1.25;  // MLD before
  }
  write_sweep(folder.path(), axes, rows);
  const std::string svg = test::file_text(folder.path() / "sweep.svg");
  EXPECT_THAT(svg, testing::HasSubstr("the same in all variants: MLD before [mm], 1.25"));
  std::size_t last = 0;
  for (const char* title : {">MLD after [mm]<", ">acute gain [mm]<", ">recoil [", ">residual st",
                            ">wall over", ">balloon-to-artery ratio<"}) {
    const std::size_t place = svg.find(title);
    ASSERT_NE(place, std::string::npos) << title;
    EXPECT_GT(place, last) << title;
    last = place;
  }
  for (const char* words : {">inflation peak pressure [atm]<", ">balloon length 10 mm<", ">12.5<"})
    EXPECT_THAT(svg, testing::HasSubstr(words));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr(">MLD before")));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr("_mm")));
}

/// Of every file, its text; without times.
std::map<std::string, std::string> content_of(const fs::path& folder) {
  std::map<std::string, std::string> content;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      content[fs::relative(entry.path(), folder)] = test::file_text(entry.path());
  return content;
}

TEST(Sweep, EqualsRunsOfTheirOwnAndLeavesTheCaseAsItWas) {
  const test::CommandFolder folder;
  const std::string quick =
      "--preset draft --set inflation.inflate_s=0.4 inflation.hold_s=0.2 inflation.deflate_s=0.4 "
      "volume.fill=false simulation.guard=false wall.model=shape_matching balloon.length_mm=6";
  const std::string input = "'phantom:concentric,length=24,stenosis=50,noise=0'";
  ASSERT_EQ(test::run_program("run " + input + " -o '" + folder / "base" + "' --until simulation " +
                              quick)
                .exit_code,
            0);
  const auto before = content_of(folder / "base");
  const std::string command =
      "sweep '" + folder / "base" + "' balloon.length_mm=6,7 -o '" + folder / "sweep" + "'";
  const test::ProgramResult result = test::run_program(command);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(content_of(folder / "base"), before);
  EXPECT_TRUE(fs::exists(folder / "sweep/sweep.svg"));
  EXPECT_EQ(nlohmann::json::parse(test::file_text(folder / "sweep/sweep.json"))["variants"].size(),
            2U);

  ASSERT_EQ(test::run_program("run " + input + " -o '" + folder / "own" + "' --until simulation " +
                              quick + " balloon.length_mm=7")
                .exit_code,
            0);
  const auto table = formats::read_csv_table(folder / "sweep/sweep.csv");
  const auto after = [&](const std::string& variant) {
    return test::file_text(fs::path(folder / variant) / "simulation/lumen_after.vtp");
  };
  EXPECT_EQ(after("sweep/length_mm-6"), after("base"));
  EXPECT_EQ(after("sweep/length_mm-7"), after("own"));
  EXPECT_NE(after("own"), after("base"));
  EXPECT_EQ(table.texts("status"), (std::vector<std::string>{"done", "done"}));

  const auto once = content_of(folder / "sweep/length_mm-7");  // nothing is made again
  ASSERT_EQ(test::run_program(command).exit_code, 0);
  EXPECT_EQ(content_of(folder / "sweep/length_mm-7"), once);
}

TEST(Sweep, RefusesWhatIsNoCaseAndWhatChangesTheReadingOfTheInput) {
  const test::CommandFolder folder;
  EXPECT_EQ(test::run_program("sweep '" + folder / "nothing" + "' balloon.length_mm=6,7").exit_code,
            66);
  ASSERT_EQ(test::run_program("run 'phantom:straight,length=20,noise=0' -o '" + folder / "base" +
                              "' --preset draft --until segmentation")
                .exit_code,
            0);
  const auto result =
      test::run_program("sweep '" + folder / "base" + "' input.resample=true,false");
  EXPECT_EQ(result.exit_code, 64) << result.error;
  EXPECT_FALSE(fs::exists(folder / "base-sweep"));
}

}  // namespace
}  // namespace angio::pipeline

#include <gtest/gtest.h>

#include <cmath>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "pipeline/config/balloon_file.hpp"
#include "run_program.hpp"
#include "simulation/balloon_size.hpp"

namespace angio::test {
namespace {

namespace fs = std::filesystem;
using pipeline::balloon_catalogue;
using pipeline::read_balloon_file;

std::string refusal(const fs::path& file) {
  try {
    read_balloon_file(file);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(BalloonCatalogue, ComesWithTheProgramAndEveryEntryIsSound) {
  const auto all = balloon_catalogue();
  EXPECT_GE(all.size(), 10u);
  for (const auto& balloon : all) EXPECT_NO_THROW(balloon.validate()) << balloon.name;
}

// Its semi-compliant balloons are the representative one at their sizes, to the figures written.
TEST(BalloonCatalogue, HoldsTheUsualBalloonAtEverySize) {
  int count = 0;
  for (const auto& balloon : balloon_catalogue()) {
    if (balloon.material != "pa12") continue;
    ++count;
    const simulation::BalloonSize usual = simulation::balloon_size(balloon.nominal_diameter_mm);
    EXPECT_NEAR(usual.wall_mm, balloon.wall_mm, 0.0005) << balloon.name;
    EXPECT_EQ(usual.nominal_pressure_atm, balloon.nominal_pressure_atm);
    EXPECT_EQ(usual.rated_burst_atm, balloon.rated_burst_pressure_atm);
    ASSERT_EQ(usual.chart.size(), balloon.chart.size());
    for (std::size_t i = 0; i < usual.chart.size(); ++i) {
      EXPECT_EQ(usual.chart[i].pressure_atm, balloon.chart[i].pressure_atm);
      EXPECT_NEAR(usual.chart[i].diameter_mm, balloon.chart[i].diameter_mm, 0.001);
    }
  }
  EXPECT_GE(count, 6);
}

TEST(BalloonCatalogue, OnesOwnEntryCountsBeforeOneOfTheSameName) {
  CommandFolder folder;
  const fs::path file = folder.path() / "own.toml";
  write_text_atomically(file,
                        "[[balloon]]\nname = \"sc-3.0\"\nnominal_diameter_mm = 3.0\n"
                        "wall_mm = 0.031\n");
  const auto all = balloon_catalogue(file);
  EXPECT_EQ(find_balloon(all, "sc-3.0").wall_mm, 0.031);
  EXPECT_EQ(all.size(), balloon_catalogue().size());
}

TEST(BalloonCatalogue, MistakesAreNamedWithTheBalloonAndTheKey) {
  CommandFolder folder;
  const fs::path file = folder.path() / "own.toml";
  const auto says = [&](const std::string& text, const std::string& words) {
    write_text_atomically(file, text);
    EXPECT_NE(refusal(file).find(words), std::string::npos) << text << "\n" << refusal(file);
  };
  says("[[balloon]]\nname = \"b\"\nwal_mm = 0.02\n", "wall_mm");
  says("[[balloon]]\nname = \"b\"\nwall_mm = \"thin\"\n", "balloon 1 (b): wall_mm");
  says("[[balloon]]\nname = \"b\"\nwall_mm = nan\n", "wall_mm");
  says("[[balloon]]\nname = \"b\"\nchart = [[1.0, 2.0], [3.0]]\n", "chart");
  says("[[balloon]]\nname = \"b\"\nchart = [[4.0, 3.0], [8.0, 2.9]]\n", "b");
  says("[[balloon]]\nname = \"b\"\n[[balloon]]\nname = \"b\"\n", "two balloons");
  says("[balloon\n", "line 1");
  says("x = 1\n", "not a balloon catalogue");
}

TEST(InflateCommand, FollowsTheChartOfABalloonAtEveryPoint) {
  CommandFolder folder;
  const ProgramResult result =
      run_program("inflate nc-3.0 --pressures 8,12,16,20 --quiet -o '" + folder / "d" + "'");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const auto rows = formats::parse_csv(read_text(folder.path() / "d" / "inflation.csv"));
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[0], (formats::CsvRow{"pressure_atm", "diameter_mm", "length_mm", "volume_mm3",
                                      "wall_mm", "chart_diameter_mm"}));
  for (std::size_t r = 1; r < rows.size(); ++r) {
    const double chart = std::stod(rows[r][5]);
    EXPECT_NEAR(std::stod(rows[r][1]) / chart, 1.0, 0.015);
  }
  EXPECT_TRUE(fs::exists(folder.path() / "d" / "inflation.svg"));
}

TEST(InflateCommand, VolumesAndTheSimulationsSolverGiveTheSameCurve) {
  CommandFolder folder;
  const auto rows_of = [&](const std::string& words) {
    const ProgramResult result =
        run_program("inflate --radius 0.5 --length 5 --wall 0.02 --material polyurethane --quiet " +
                    words + " -o '" + folder / "d" + "'");
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return formats::parse_csv(read_text(folder.path() / "d" / "inflation.csv"));
  };
  const auto pressed = rows_of("--pressures 1,2");
  const auto filled = rows_of("--volumes " + pressed[1][3] + "," + pressed[2][3]);
  const auto descended = rows_of("--pressures 1,2 --solver vbd --backend cpu");
  for (std::size_t r = 1; r < 3; ++r) {
    EXPECT_NEAR(std::stod(filled[r][0]), std::stod(pressed[r][0]), 1e-4);
    EXPECT_NEAR(std::stod(descended[r][1]) / std::stod(pressed[r][1]), 1.0, 1e-3);
    EXPECT_TRUE(pressed[r][5].empty());  // no chart
  }
}

TEST(InflateCommand, WrongWordsAreOneLine) {
  CommandFolder folder;
  const auto fails = [&](const std::string& words, int code, const std::string& hint) {
    const ProgramResult result = run_program("inflate " + words);
    EXPECT_EQ(result.exit_code, code) << words << "\n" << result.error;
    EXPECT_EQ(result.error_line_count(), 1) << result.error;
    EXPECT_NE(result.error.find(hint), std::string::npos) << result.error;
  };
  const std::string out = " -o '" + folder / "d" + "'";
  fails("sc-3.0", 64, "-o");
  fails("sc-3.1" + out, 78, "sc-3.0");
  fails("sc-3.0 --radius 2" + out, 64, "--radius");
  fails("--radius 1.5 --length 15 --wall 0.02 --material pa12" + out, 64, "--pressures");
  fails("--radius 1.5 --length 15 --wall 0.02 --material rubber --pressures 1" + out, 78, "pa12");
  fails("--radius 1.5 --length 15 --wall 0 --material pa12 --pressures 1" + out, 64, "--wall");
  fails("sc-3.0 --pressures 1 --volumes 100" + out, 64, "--volumes");
  fails("sc-3.0 --pressures -1" + out, 78, "pressure");
  fails("sc-3.0 --catalogue /nowhere.toml" + out, 66, "/nowhere.toml");
  EXPECT_FALSE(fs::exists(folder.path() / "d"));
}

}  // namespace
}  // namespace angio::test

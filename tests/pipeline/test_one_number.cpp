// Every output of a case tells the same numbers, and those are its geometry's.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "formats/csv.hpp"
#include "formats/text.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/config/config.hpp"
#include "run_program.hpp"

namespace angio::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json json_file(const fs::path& file) { return json::parse(file_text(file)); }

/// A table's rows as number by column; what is no number is left out.
using Row = std::map<std::string, double>;
std::vector<Row> table(const fs::path& file) {
  const auto rows = formats::parse_csv(file_text(file));
  std::vector<Row> numbers;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    numbers.emplace_back();
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      std::size_t end = 0;
      try {
        const double value = std::stod(rows[r][c], &end);
        if (end == rows[r][c].size()) numbers.back()[rows[0][c]] = value;
      } catch (const std::invalid_argument&) {
      }
    }
  }
  return numbers;
}

double least_within(const std::vector<Row>& rows, const std::string& column, double first,
                    double last) {
  double least = std::numeric_limits<double>::max();
  for (const Row& row : rows)
    if (row.at("abscissa_mm") >= first - 5e-5 && row.at("abscissa_mm") <= last + 5e-5)
      least = std::min(least, row.at(column));
  return least;
}

/// Three cases by `angio batch`: a stenosis with the second run, and a healthy vessel.
class OneNumber : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new CommandFolder;
    std::ofstream(*folder_ / "m.csv")
        << "case,input,simulation.guard\n"
        << "narrow,\"phantom:concentric,length=24,stenosis=50,noise=0\",true\n"
        << "healthy,\"phantom:straight,length=20,noise=0\",\n";
    result_ = new ProgramResult(run_program(
        "batch '" + *folder_ / "m.csv" + "' -o '" + *folder_ / "out" +
        "' --preset draft --set balloon.length_mm=6 inflation.inflate_s=1 inflation.hold_s=0.5 "
        "inflation.deflate_s=1 volume.fill=false"));
  }
  static void TearDownTestSuite() {
    delete result_;
    delete folder_;
  }
  void SetUp() override {
    ASSERT_EQ(result_->exit_code, 0) << result_->error;
    root_ = folder_->path() / "out/narrow";
    metrics_ = json_file(root_ / "metrics.json");
    summary_ = json_file(root_ / "simulation/summary.json");
  }
  [[nodiscard]] double number(const char* group, const char* key) const {
    return metrics_.at(group).at(key).get<double>();
  }
  [[nodiscard]] static fs::path batch_folder() { return folder_->path() / "out"; }

  fs::path root_;
  json metrics_, summary_;

  /// Before, at peak, after: the metrics' group, the profile's word, the frame.
  struct When {
    const char* group;
    const char* word;
    int frame;
  };
  [[nodiscard]] std::vector<When> times() const {
    return {{"lesion", "before", 0},
            {"peak", "peak", summary_.at("peak_frame").get<int>()},
            {"result", "after", summary_.at("last_frame").get<int>()}};
  }

 private:
  static CommandFolder* folder_;
  static ProgramResult* result_;
};
CommandFolder* OneNumber::folder_ = nullptr;
ProgramResult* OneNumber::result_ = nullptr;

TEST_F(OneNumber, OfMetricsAndSummaryIsTheSame) {
  for (const char* group : {"lesion", "peak", "result"})
    for (const auto& [key, value] : summary_.at(group).items())
      EXPECT_EQ(metrics_.at(group).at(key), value) << group << "." << key;
}

TEST_F(OneNumber, IsTheTimeSeriesAtTheFirstThePeakAndTheLastFrame) {
  const auto rows = table(root_ / "simulation/timeseries.csv");
  for (const When& when : times()) {
    ASSERT_EQ(rows.at(std::size_t(when.frame)).at("frame"), when.frame);
    EXPECT_NEAR(rows[std::size_t(when.frame)].at("lumen_mld_mm"), number(when.group, "mld_mm"),
                2e-5)
        << when.group;
  }
}

TEST_F(OneNumber, IsTheLeastOfTheProfileWhereTheLesionIsTreated) {
  const auto rows = table(root_ / "simulation/lumen_profile.csv");
  const double first = number("lesion", "treated_first_mm"),
               last = number("lesion", "treated_last_mm");
  for (const When& when : times()) {
    const std::string word = std::string(when.word) + "_mm";
    EXPECT_NEAR(least_within(rows, "inscribed_diameter_" + word, first, last),
                number(when.group, "mld_mm"), 1e-5)
        << when.group;
    const double diameter = least_within(rows, "equivalent_diameter_" + word, first, last);
    EXPECT_NEAR(0.25 * units::kPi * diameter * diameter, number(when.group, "mla_mm2"), 1e-4);
    EXPECT_NEAR(least_within(rows, "inscribed_diameter_" + word, -1e9, 1e9),
                number(when.group, "segment_mld_mm"), 1e-5);
  }
}

// The balloon's wall is the lumen that blood flows through; the report's curve is the metrics'.
TEST_F(OneNumber, OfTheFlowIsOfTheSimulatedWall) {
  const auto rows = table(root_ / "report/flow.csv"),
             profile = table(root_ / "simulation/lumen_profile.csv");
  ASSERT_GT(rows.size(), 20u);
  for (const char* when : {"before", "after"}) {
    const std::string word = when;
    std::size_t compared = 0;
    for (const Row& row : rows) {
      EXPECT_NEAR(row.at("pressure_" + word + "_mmhg"), 93.0 * row.at("ffr_" + word), 0.01);
      EXPECT_LE(row.at("ffr_" + word + "_low"), row.at("ffr_" + word));
      EXPECT_GE(row.at("ffr_" + word + "_high"), row.at("ffr_" + word));
      for (const Row& wall : profile) {
        const std::string diameter = "equivalent_diameter_" + word + "_mm";
        if (std::abs(wall.at("abscissa_mm") - row.at("abscissa_mm")) > 1e-4 ||
            !wall.contains(diameter) || !row.contains("diameter_" + word + "_mm"))
          continue;
        EXPECT_NEAR(row.at("diameter_" + word + "_mm"), wall.at(diameter), 2e-4);
        ++compared;
      }
    }
    EXPECT_GT(compared, 10u);
    const auto behind = std::find_if(rows.begin(), rows.end(), [&](const Row& row) {
      return row.at("abscissa_mm") >= number("flow", "behind_mm");
    });
    ASSERT_NE(behind, rows.end());
    EXPECT_NEAR(behind->at("ffr_" + word), number("flow", ("ffr_" + word).c_str()), 2e-3);
  }
  EXPECT_GT(number("flow", "ffr_after"), number("flow", "ffr_before"));
  EXPECT_LT(number("flow", "pressure_drop_after_mmhg"),
            number("flow", "pressure_drop_before_mmhg"));
  EXPECT_TRUE(metrics_.at("flow").at("reason").is_null());
  EXPECT_EQ(metrics_.at("flow").at("vessel"), "coronary");  // the phantoms'
}

// The phantom's vessel is straight: some view shows all of its length, and nothing hides it.
TEST_F(OneNumber, OfTheWorkingViewIsInTheReportAndOfAStraightVesselNearlyWithoutForeshortening) {
  const json& view = metrics_.at("working_view");
  EXPECT_LT(number("working_view", "foreshortening_percent"), 1.5);
  EXPECT_EQ(number("working_view", "overlap_percent"), 0.0);
  EXPECT_EQ(view.at("patient_axes"), "stated");
  EXPECT_TRUE(view.at("reason").is_null());
  const std::string page = file_text(root_ / "report/index.html"),
                    label = view.at("label").get<std::string>();
  EXPECT_NE(page.find("<strong>" + label + "</strong> shortens"), std::string::npos);
  EXPECT_NE(page.find("After, " + label), std::string::npos);
  EXPECT_NE(page.find("Before, " + view.at("second_label").get<std::string>()), std::string::npos);
}

TEST_F(OneNumber, OfTheFlowIsNoneWithoutAStenosis) {
  const json healthy = json_file(batch_folder() / "healthy/metrics.json").at("flow");
  EXPECT_EQ(healthy.at("reason"), "no stenosis is certain");
  EXPECT_TRUE(healthy.at("ffr_before").is_null());
  EXPECT_FALSE(fs::exists(batch_folder() / "healthy/report/flow.csv"));
}

// Twice the distance of the wall's nearest vertex from the phantom's axis, between the edges.
TEST_F(OneNumber, IsThatOfTheFramesThatAreWritten) {
  const json site = json_file(root_ / "meshing/placement.json").at("site");
  const auto vec = [&](const char* key) {
    return Vec3{site.at(key).at(0).get<double>(), site.at(key).at(1).get<double>(),
                site.at(key).at(2).get<double>()};
  };
  const Vec3 point = vec("point"), tangent = normalized(vec("tangent"));
  const double throat = number("lesion", "abscissa_mm");
  for (const When& when : times()) {
    const auto shape = pipeline::read_frame(root_ / "simulation/frames", when.frame);
    double least = std::numeric_limits<double>::max();
    for (const Vec3& p : shape.wall.vertices) {
      const double s = dot(p - point, tangent), place = throat + s;
      if (place < number("lesion", "treated_first_mm") ||
          place > number("lesion", "treated_last_mm"))
        continue;
      least = std::min(least, norm(p - point - s * tangent));
    }
    EXPECT_NEAR(2.0 * least, number(when.group, "mld_mm"), 0.08) << when.group;
  }
}

TEST_F(OneNumber, GainAndRecoilAreDifferencesOfIt) {
  EXPECT_NEAR(number("result", "acute_gain_mm"),
              number("result", "mld_mm") - number("lesion", "mld_mm"), 1e-12);
  EXPECT_NEAR(number("result", "recoil_mm"), number("peak", "mld_mm") - number("result", "mld_mm"),
              1e-12);
  EXPECT_NEAR(number("result", "recoil_percent"),
              100.0 * number("result", "recoil_mm") / number("peak", "mld_mm"), 1e-12);
  EXPECT_GT(number("result", "recoil_mm"), 0.0);
  // The lumen is as wide as the balloon that holds it open, but for the gap on both sides and the
  // two surfaces' facets, which lie inside the circles of their vertices.
  const double over = number("peak", "mld_mm") - number("balloon", "peak_diameter_mm");
  EXPECT_GT(over, 0.0);
  EXPECT_LT(over, 2.5 * number("peak", "contact_gap_mm"));
}

TEST_F(OneNumber, CanBeDrivenLive) {
  const ProgramResult live = run_program("live '" + root_.string() + "' --seconds 0.2");
  EXPECT_TRUE(live.exit_code == 0 || live.exit_code == 69) << live.error;  // 69: no display
}

TEST_F(OneNumber, IsTheReports) {
  const std::string page = file_text(root_ / "report/index.html");
  const auto mm = [&](const char* group) {
    return formats::fixed_text(number(group, "mld_mm"), 2) + " mm";
  };
  EXPECT_NE(page.find(formats::fixed_text(number("lesion", "mld_mm"), 2) + " → " + mm("result")),
            std::string::npos);
  EXPECT_NE(page.find("at peak " + mm("peak")), std::string::npos);
  EXPECT_NE(page.find("MLD before " + mm("lesion")), std::string::npos);
  EXPECT_NE(page.find("MLD at peak " + mm("peak")), std::string::npos);
  EXPECT_NE(page.find("MLD after " + mm("result")), std::string::npos);
}

TEST_F(OneNumber, IsTheBatchSummarys) {
  const auto cells = formats::parse_csv(file_text(batch_folder() / "summary.csv"));
  const auto rows = table(batch_folder() / "summary.csv");
  ASSERT_EQ(rows.size(), 2U);
  for (const When& when : times())
    EXPECT_NEAR(rows[0].at(std::string(when.group) + ".mld_mm"), number(when.group, "mld_mm"),
                5e-4);
  EXPECT_NEAR(rows[0].at("result.recoil_percent"), number("result", "recoil_percent"), 5e-3);
  const auto column =
      std::size_t(std::find(cells[0].begin(), cells[0].end(), "case_status") - cells[0].begin());
  ASSERT_LT(column, cells[0].size());
  EXPECT_EQ(cells[1].at(column), "done");
  EXPECT_EQ(cells[2].at(column), "no_lesion");
}

TEST_F(OneNumber, HoldsTheSecondRunsRange) {
  EXPECT_EQ(metrics_.at("simulation").at("guard"), "agrees");
  const json& result = metrics_.at("result");
  const auto within = [&](const char* key, const char* range) {
    const double low = result.at(range).at(0).get<double>(),
                 high = result.at(range).at(1).get<double>();
    EXPECT_LE(low, number("result", key)) << range;
    EXPECT_GE(high, number("result", key)) << range;
    EXPECT_LT(low, high) << range;  // it was another run
  };
  within("mld_mm", "mld_range_mm");
  within("acute_gain_mm", "acute_gain_range_mm");
  within("recoil_percent", "recoil_range_percent");
  const json healthy = json_file(batch_folder() / "healthy/metrics.json");
  EXPECT_EQ(healthy.at("status"), "no_lesion");
  EXPECT_EQ(healthy.at("simulation").at("guard"), "off");  // `draft`
  EXPECT_TRUE(healthy.at("result").at("mld_range_mm").is_null());
}

TEST(NoLesion, IsWhatAHealthyVesselHasUnderEveryPreset) {
  const CommandFolder folder;
  for (const std::string& preset : pipeline::preset_names()) {
    if (preset.starts_with("paper-")) continue;  // they bring their own vessel or narrow it
    const std::string root = folder / preset;
    const ProgramResult run =
        run_program("run phantom:straight,length=20,noise=0 --until meshing --quiet --preset " +
                    preset + " -o '" + root + "' --set volume.fill=false");
    ASSERT_EQ(run.exit_code, 0) << preset << run.error;
    EXPECT_EQ(json_file(fs::path(root) / "meshing/placement.json").at("status"), "no_lesion")
        << preset;
  }
}

}  // namespace
}  // namespace angio::test

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/files.hpp"
#include "tests/pipeline/run_program.hpp"

// From angiograms of a C-arm that stood still to the lumen, as a user goes.
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

/// An attribute of numbers, as text, as explicit little endian DICOM has it.
std::string attribute(int group, int element, std::string value) {
  if (value.size() % 2 != 0) value += ' ';
  const auto word = [](std::size_t number) {
    return std::string{char(number & 0xFFU), char(number >> 8U & 0xFFU)};
  };
  return word(std::size_t(group)) + word(std::size_t(element)) + "IS" + word(value.size()) + value;
}

/// Adds attributes to a DICOM file, before its pixels.
void add_to_header(const fs::path& file, const std::string& attributes) {
  std::string text = file_text(file);
  const std::size_t pixels = text.find(std::string("\xE0\x7F\x10\x00OW", 6));
  ASSERT_NE(pixels, std::string::npos);
  text.insert(pixels, attributes);
  std::ofstream(file, std::ios::binary) << text;
}

class Views : public testing::Test {
 protected:
  /// Two views of a vessel of 30 mm along the body's axis, with a stenosis of 60 %.
  std::string make_views(const std::string& name) {
    const std::string out = folder_ / name;
    const ProgramResult made =
        run_program("phantom concentric --length 30 --no-body --format xa-views -o '" + out + "'");
    EXPECT_EQ(made.exit_code, 0) << made.error;
    return out + "/xa_views";
  }
  ProgramResult run(const std::string& input, const std::string& name,
                    const std::string& more = "--until centerline") {
    return run_program("run '" + input + "' -o '" + folder_ / name + "' " + more);
  }
  /// The lowest row of each view that shows a point of the fitted lines.
  std::vector<double> last_rows(const std::string& name) {
    const fs::path stage = folder_.path() / name / "reconstruction";
    std::vector<double> rows;
    for (const json& frame : json_of(stage / "frames.json").at("frames")) {
      const auto matrix = frame.at("matrix").get<std::array<std::array<double, 4>, 3>>();
      double& last = rows.emplace_back(0.0);
      for (const Vec3& p : formats::read_polylines(stage / "centerlines.vtp").points) {
        const auto seen = [&](std::size_t n) {
          return matrix[n][0] * p.x + matrix[n][1] * p.y + matrix[n][2] * p.z + matrix[n][3];
        };
        last = std::max(last, seen(1) / seen(2));
      }
    }
    return rows;
  }
  CommandFolder folder_;
};

TEST_F(Views, GiveTheThroatWithItsStandardDeviation) {
  const ProgramResult result = run(make_views("xa"), "case");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json lesion = json_of(folder_.path() / "case/metrics.json").at("lesion");
  EXPECT_NEAR(lesion.at("mld_mm").get<double>(), 1.2, 0.15);
  EXPECT_GT(lesion.at("mld_sd_mm").get<double>(), 0.0);
  EXPECT_LT(lesion.at("mld_sd_mm").get<double>(), 0.2);
}

TEST_F(Views, BehindTheirHeadersShutterAreNotUsed) {
  const std::string input = make_views("xa");
  ASSERT_EQ(run(input, "open", "--until reconstruction").exit_code, 0);
  constexpr double kLastRow = 100.0;  // numbered from 1
  for (const auto& entry : fs::directory_iterator(input))
    add_to_header(entry.path(), attribute(0x0018, 0x1608, "100"));
  const ProgramResult covered = run(input, "covered", "--until reconstruction");
  ASSERT_EQ(covered.exit_code, 0) << covered.error;
  for (const double row : last_rows("open")) EXPECT_GT(row, kLastRow + 5.0);
  for (const double row : last_rows("covered")) {
    EXPECT_LT(row, kLastRow);
    EXPECT_GT(row, kLastRow - 30.0);
  }
}

TEST_F(Views, BehindTheSlopeOfAPolygonalShutterAreNotUsed) {
  // It cuts the vessel, near column 71, at row 100; the rectangle around it goes to row 120, and
  // what it covers takes the nearest open pixels' values, of a vessel, too.
  const std::string input = make_views("xa");
  for (const auto& entry : fs::directory_iterator(input))
    add_to_header(entry.path(), attribute(0x0018, 0x1620, "1\\1\\1\\142\\80\\142\\120\\1"));
  const ProgramResult covered = run(input, "covered", "--until reconstruction");
  ASSERT_EQ(covered.exit_code, 0) << covered.error;
  for (const double row : last_rows("covered")) {
    EXPECT_LT(row, 105.0);
    EXPECT_GT(row, 80.0);
  }
  const json quality = json_of(folder_.path() / "covered/reconstruction/quality.json");
  for (const json& view : quality.at("views"))
    EXPECT_NEAR(view.at("contrast_per_mm").get<double>(), 0.1, 0.01);
}

}  // namespace
}  // namespace angio::pipeline

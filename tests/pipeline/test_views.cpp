#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "formats/files.hpp"
#include "tests/pipeline/run_program.hpp"

// From angiograms of a C-arm that stood still to the lumen, as a user goes.
namespace angio::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::CommandFolder;
using test::file_text;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;

json json_of(const fs::path& file) { return json::parse(file_text(file)); }

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
  /// Between the highest and the lowest point of the fitted lines [mm].
  double height(const std::string& name) {
    const auto lines =
        formats::read_polylines(folder_.path() / name / "reconstruction/centerlines.vtp");
    double low = 1e9, high = -1e9;
    for (const Vec3& point : lines.points) {
      low = std::min(low, point.z);
      high = std::max(high, point.z);
    }
    return high - low;
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
  // The vessel reaches to about row 120; a row is 0.3 mm at the isocentre.
  for (const auto& entry : fs::directory_iterator(input))
    add_to_header(entry.path(), attribute(0x0018, 0x1608, "100"));
  const ProgramResult covered = run(input, "covered", "--until reconstruction");
  ASSERT_EQ(covered.exit_code, 0) << covered.error;
  EXPECT_NEAR(height("open"), 30.0, 2.0);
  EXPECT_NEAR(height("open") - height("covered"), 20 * 0.3, 2.0);
}

}  // namespace
}  // namespace angio::pipeline

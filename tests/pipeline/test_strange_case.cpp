// A case folder that comes from elsewhere: what does not hold together in it is refused with one
// line, and never read past its end.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>

#include "core/error.hpp"
#include "formats/files.hpp"
#include "run_program.hpp"

namespace angio::test {
namespace {

namespace fs = std::filesystem;

/// What is done to a file of a good case, and the stage that then reads it.
struct Damage {
  const char* name;
  const char* file;
  const char* verb;
  std::function<void(const fs::path& file)> apply;
};

void set_text(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

void replace(const fs::path& file, const std::string& from, const std::string& to) {
  std::string text = file_text(file);
  const auto at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  set_text(file, text.replace(at, from.size(), to));
}

/// Sets a value of a point array of a surface.
std::function<void(const fs::path&)> with(const std::string& array, double value) {
  return [=](const fs::path& file) {
    formats::SurfaceData data = formats::read_surface(file);
    for (DataArray& a : data.point_arrays)
      if (a.name == array) {
        a.type = ArrayType::float64;
        a.values.at(3) = value;
      }
    formats::write_surface(file, data);
  };
}

std::function<void(const fs::path&)> with_line_value(const std::string& array, double value) {
  return [=](const fs::path& file) {
    formats::PolylineData data = formats::read_polylines(file);
    for (std::vector<DataArray>* arrays : {&data.point_arrays, &data.cell_arrays})
      for (DataArray& a : *arrays)
        if (a.name == array) {
          a.type = ArrayType::float64;
          a.values.at(0) = value;
        }
    formats::write_polylines(file, data);
  };
}

void cut_rows(const fs::path& file) {
  const std::string text = file_text(file);
  set_text(file, text.substr(0, text.find('\n', text.find('\n') + 1) + 9));
}

const Damage kDamages[] = {
    {"IdsPastTheLumen", "meshing/region.vtp", "simulate", with("LumenVertexIds", 1e8)},
    {"IdsBelowZero", "meshing/region.vtp", "simulate", with("LumenVertexIds", -7.0)},
    {"AbscissasBeyondAnyVessel", "meshing/region.vtp", "simulate", with("Abscissas", 1e300)},
    {"FlagsThatAreNone", "meshing/balloon.vtp", "simulate", with("Fixed", 77.0)},
    {"RadiiBeyondAnyVessel", "centerline/centerlines.vtp", "mesh",
     with_line_value("MaximumInscribedSphereRadius", 1e300)},
    {"LinesThatRunBack", "centerline/centerlines.vtp", "report",
     with_line_value("Abscissas", 99.0)},
    {"LineNumbersBelowZero", "centerline/centerlines.vtp", "report",
     with_line_value("CenterlineIds", -1e300)},
    {"NoFrames", "simulation/simulation.pvd", "report",
     [](const fs::path& file) { set_text(file, ""); }},
    {"AListWithoutFrames", "simulation/simulation.pvd", "report",
     [](const fs::path& file) {
       set_text(file, "<VTKFile type=\"Collection\"><Collection></Collection></VTKFile>");
     }},
    {"NestedBrackets", "centerline/lesions.json", "report",
     [](const fs::path& file) { set_text(file, std::string(200000, '[')); }},
    {"AWordForANumber", "simulation/lumen_profile.csv", "report",
     [](const fs::path& file) { replace(file, "\n", "\nabc"); }},
    {"ARowCutShort", "simulation/lumen_profile.csv", "report", cut_rows},
    {"ATableOfOneRow", "simulation/timeseries.csv", "report", cut_rows},
    {"AnotherPeak", "simulation/summary.json", "report",
     [](const fs::path& file) { replace(file, "\"peak_frame\": ", "\"peak_frame\": 1"); }},
};

class StrangeCase : public testing::TestWithParam<Damage> {
 protected:
  static void SetUpTestSuite() {
    folder_ = new CommandFolder;
    result_ = new ProgramResult(run_program(
        "run 'phantom:concentric,length=24,stenosis=50,noise=0' -o '" + *folder_ / "good" +
        "' --preset draft --until simulation --set balloon.length_mm=6 inflation.inflate_s=0.4 "
        "inflation.hold_s=0.2 inflation.deflate_s=0.4 volume.fill=false simulation.guard=false "
        "wall.model=shape_matching"));
  }
  static void TearDownTestSuite() {
    delete result_;
    delete folder_;
  }
  void SetUp() override { ASSERT_EQ(result_->exit_code, 0) << result_->error; }

  static CommandFolder* folder_;

 private:
  static ProgramResult* result_;
};
CommandFolder* StrangeCase::folder_ = nullptr;
ProgramResult* StrangeCase::result_ = nullptr;

TEST_P(StrangeCase, IsRefusedWithOneLineThatNamesTheFile) {
  const Damage& damage = GetParam();
  const CommandFolder folder;
  fs::copy(folder_->path() / "good", folder.path() / "case", fs::copy_options::recursive);
  damage.apply(folder.path() / "case" / damage.file);
  const ProgramResult result =
      run_program(std::string(damage.verb) + " '" + folder / "case" + "' --quiet");
  EXPECT_EQ(result.exit_code, int(ExitCode::bad_data)) << result.error;
  EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
  EXPECT_THAT(result.error, testing::HasSubstr(fs::path(damage.file).filename().string()));
}

INSTANTIATE_TEST_SUITE_P(, StrangeCase, testing::ValuesIn(kDamages),
                         [](const testing::TestParamInfo<Damage>& damage) {
                           return std::string(damage.param.name);
                         });

}  // namespace
}  // namespace angio::test

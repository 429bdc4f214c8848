// The seed paper's experiments, as presets of the program; and runs with a clear end.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "core/triangle_mesh.hpp"
#include "datasets/phantom.hpp"
#include "formats/csv.hpp"
#include "formats/files.hpp"
#include "meshing/meshing.hpp"
#include "meshing/narrow_lumen.hpp"
#include "run_program.hpp"
#include "testing/pipeline/case_content.hpp"

namespace angio::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Columns of a CSV file by their names.
std::map<std::string, std::vector<double>> read_columns(const fs::path& file) {
  const auto rows = formats::parse_csv(file_text(file));
  std::map<std::string, std::vector<double>> columns;
  for (std::size_t r = 1; r < rows.size(); ++r)
    for (std::size_t c = 0; c < rows[r].size(); ++c)
      columns[rows[0][c]].push_back(std::atof(rows[r][c].c_str()));
  return columns;
}

void expect_counts(const fs::path& file, std::size_t triangles, std::size_t vertices) {
  const TriangleMesh mesh = formats::read_surface(file).mesh;
  EXPECT_EQ(mesh.triangles.size(), triangles) << file;
  EXPECT_EQ(mesh.vertices.size(), vertices) << file;
}

void expect_paper_balloon(const fs::path& case_folder) {
  expect_counts(case_folder / "meshing/balloon.vtp", 1040, 522);
  const auto wire = formats::read_polylines(case_folder / "meshing/guidewire.vtp");
  const auto& inside = formats::find_array(wire.point_arrays, "InBalloon").values;
  EXPECT_EQ(inside.size(), wire.points.size());
  EXPECT_EQ(std::count(inside.begin(), inside.end(), 1.0), 24);
  EXPECT_EQ(inside.front() + inside.back(), 0.0);  // it runs on along the vessel
}

/// A few frames of a gentle inflation.
const std::string kQuick =
    " --quiet --set simulation.frame_s=0.05 inflation.inflate_s=0.4 inflation.deflate_s=0.2 "
    "inflation.rest_s=0 inflation.peak_pressure_atm=2 simulation.write_every=2";

TEST(PaperCloth, IsPulledThinnerAtItsCornersAndAlongItsDiagonals) {
  CommandFolder folder;
  const ProgramResult run = run_program("run --preset paper-cloth -o '" + folder / "c" + "'");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  const fs::path c = folder.path() / "c";
  expect_counts(c / "meshing/cloth.vtp", 5000, 2601);
  const auto columns = read_columns(c / "simulation/cloth.csv");
  EXPECT_NEAR(columns.at("corner_distance_mm").back() / columns.at("corner_distance_mm").front(),
              1.35, 1e-6);
  for (const char* column : {"thickness_min_mm", "thickness_mean_mm", "thickness_max_mm"})
    EXPECT_TRUE(std::is_sorted(columns.at(column).rbegin(), columns.at(column).rend())) << column;
  EXPECT_LT(columns.at("thickness_center_mm").back(), columns.at("thickness_max_mm").back());
  EXPECT_TRUE(fs::exists(c / "report/cloth.png"));
  EXPECT_TRUE(fs::exists(c / "report/index.html"));
  const json stages = read_json_file(c / "run.json").at("stages");
  EXPECT_EQ(stages.at("segmentation").at("status"), "skipped");
  EXPECT_EQ(stages.at("centerline").at("status"), "skipped");
  EXPECT_EQ(stages.at("simulation").at("status"), "done");
  EXPECT_EQ(
      run_program("run phantom:cloth --preset paper-cloth -o '" + folder / "c" + "'").exit_code,
      0);  // up to date: the input may be named or not
}

TEST(PaperUnilateral, FrictionGrowsWithContactAndFallsAtDeflationWhenAdhesionRises) {
  CommandFolder folder;
  const ProgramResult run = run_program("run --preset paper-unilateral --quiet -o '" +
                                        folder / "u" + "' --set simulation.frame_s=0.05");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  const fs::path u = folder.path() / "u";
  expect_counts(u / "meshing/lumen.vtp", 2400, 1220);
  expect_paper_balloon(u);
  for (const char* file : {"index.html", "sequence.png", "corrections.svg"})
    EXPECT_TRUE(fs::exists(u / "report" / file)) << file;

  const auto series = read_columns(u / "simulation/timeseries.csv");
  const auto& time = series.at("time_s");
  const auto& friction = series.at("friction_delta_mm");
  const auto& viscous = series.at("viscous_delta_mm");
  const auto greatest = [&](const std::vector<double>& values, double from, double to) {
    double most = 0.0;
    for (std::size_t i = 0; i < time.size(); ++i)
      if (time[i] >= from && time[i] <= to) most = std::max(most, values[i]);
    return most;
  };
  const double deflation = 4.55;  // the paper: 4.505 s
  const double peak = greatest(friction, 0.0, deflation + 0.1);
  EXPECT_GT(peak, 0.0);
  EXPECT_LT(greatest(friction, 0.0, 0.3), 0.02 * peak);  // before it touches
  EXPECT_LT(greatest(friction, 0.0, 1.0), greatest(friction, 2.5, deflation));
  EXPECT_LT(greatest(friction, deflation + 1.0, 8.0), 0.02 * peak);  // parted
  const double adhesion_in_inflation = greatest(viscous, 0.0, deflation - 0.1);
  const double adhesion_in_deflation = greatest(viscous, deflation, deflation + 0.6);
  EXPECT_GT(adhesion_in_deflation, adhesion_in_inflation);
  EXPECT_LT(viscous.back(), 0.2 * adhesion_in_deflation);
  EXPECT_EQ(*std::max_element(series.at("max_penetration_mm").begin(),
                              series.at("max_penetration_mm").end()),
            0.0);
  const json metrics = read_json_file(u / "metrics.json");
  EXPECT_GT(metrics.at("result").at("mld_mm").get<double>(),
            metrics.at("lesion").at("mld_mm").get<double>() + 0.8);
}

struct Experiment {
  const char* name;
  std::size_t triangles, vertices;
};
class PaperVessel : public testing::TestWithParam<Experiment> {};

TEST_P(PaperVessel, RunsFromTheMeshOfTable2ToTheReport) {
  CommandFolder folder;
  const std::string c = folder / "c";
  const ProgramResult run = run_program(std::string("run --preset paper-") + GetParam().name +
                                        " -o '" + c + "'" + kQuick);
  ASSERT_EQ(run.exit_code, 0) << run.error;
  expect_counts(fs::path(c) / "meshing/lumen.vtp", GetParam().triangles, GetParam().vertices);
  expect_paper_balloon(c);
  EXPECT_TRUE(fs::exists(fs::path(c) / "report/sequence.png"));
  EXPECT_EQ(read_json_file(fs::path(c) / "metrics.json")
                .at("simulation")
                .at("max_penetration_mm")
                .get<double>(),
            0.0);
}

INSTANTIATE_TEST_SUITE_P(Table2, PaperVessel,
                         testing::Values(Experiment{"bilateral", 2400, 1220},
                                         Experiment{"ytype", 17600, 8859}));

TEST(PaperCoronary, HasTheCountsOfTable2) {
  CommandFolder folder;
  const ProgramResult run =
      run_program("run --preset paper-coronary --quiet --until meshing -o '" + folder / "c" + "'");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  EXPECT_NE(run.error.find("generated coronary"), std::string::npos) << run.error;
  expect_counts(folder.path() / "c/meshing/lumen.vtp", 30420, 15215);
  const TriangleMesh lumen = formats::read_surface(folder.path() / "c/meshing/lumen.vtp").mesh;
  EXPECT_EQ(boundary_loops(lumen).size(), 1u);
  EXPECT_EQ(meshing::count_self_intersections(lumen), 0);
}

TEST(Narrowing, MakesTheStenosisThatIsAskedFor) {
  CommandFolder folder;
  for (const double percent : {40.0, 60.0}) {
    const std::string c = folder / std::to_string(int(percent));
    const ProgramResult run = run_program(
        "run phantom:straight,noise=0,length=30 --preset draft --quiet --until meshing -o '" + c +
        "' --set volume.fill=false lesion.narrow_percent=" + std::to_string(percent));
    ASSERT_EQ(run.exit_code, 0) << run.error;
    EXPECT_NE(run.error.find("made, not the patient's"), std::string::npos) << run.error;
    const json lesion = read_json_file(c + "/metrics.json").at("lesion");
    EXPECT_NEAR(lesion.at("diameter_stenosis_percent").get<double>(), percent, 3.0);
    const formats::PolylineData paths =
        formats::read_polylines(fs::path(c) / "centerline/paths.vtp");
    const double length = distance(paths.points.front(), paths.points.back());
    EXPECT_GT(length, 25.0);
    EXPECT_NEAR(lesion.at("abscissa_mm").get<double>(), 0.5 * length, 0.3);  // the middle
  }
}

TEST(Narrowing, LeavesAnAnatomyWithAStenosisAlone) {
  CommandFolder folder;
  const ProgramResult run = run_program(
      "run phantom:concentric,noise=0,length=30 --preset draft --quiet --until centerline -o '" +
      folder / "c" + "' --set lesion.narrow_percent=80");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  EXPECT_NE(run.error.find("nothing was narrowed"), std::string::npos) << run.error;
  EXPECT_FALSE(fs::exists(folder.path() / "c/centerline/narrowed_lumen.vtp"));
}

TEST(Narrowing, MovesOnlyTheWallOfItsOwnVessel) {
  const datasets::Phantom y =
      datasets::make_phantom_surface(datasets::parse_phantom("ytype,stenosis=0"));
  const CenterlinePath& path = y.truth.tree.paths[0];
  const meshing::Narrowing narrowing{path.id, 35.0, 9.0, 2.86};
  const TriangleMesh narrowed = meshing::narrow_lumen(y.surface, path, narrowing, 50.0);
  double deepest = 1.0;
  for (std::size_t v = 0; v < narrowed.vertices.size(); ++v) {
    const Vec3& before = y.surface.vertices[v];
    const double moved = distance(before, narrowed.vertices[v]);
    const double s = project(path, before);
    const CenterlineSample line = sample(path, s);
    if (std::abs(s - 35.0) > 4.5) {
      EXPECT_EQ(moved, 0.0);
    } else if (distance(before, line.point) < 1.5 * line.inscribed_radius) {
      deepest = std::min(deepest,
                         distance(narrowed.vertices[v], line.point) / distance(before, line.point));
    }
  }
  EXPECT_NEAR(deepest, 0.5, 0.01);
}

// ---- clear ends --------------------------------------------------------------------------------

struct Refusal {
  const char* name;
  const char* arguments;
  int exit_code;
  const char* tells;
};
void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.name; }
class ClearEnd : public testing::TestWithParam<Refusal> {};

TEST_P(ClearEnd, IsOneLineThatSaysWhatToDo) {
  CommandFolder folder;
  const ProgramResult run = run_program(std::string("run ") + GetParam().arguments +
                                        " --quiet -o '" + folder / "c" + "' --until meshing");
  EXPECT_EQ(run.exit_code, GetParam().exit_code) << run.error;
  EXPECT_NE(run.error.find(GetParam().tells), std::string::npos) << run.error;
}

INSTANTIATE_TEST_SUITE_P(
    Runs, ClearEnd,
    testing::Values(
        Refusal{"TotalOcclusion", "phantom:unilateral,stenosis=95 --preset paper-unilateral", 65,
                "a balloon crosses a lumen of at least 0.24 mm"},
        Refusal{"OcclusionAskedFor",
                "phantom:straight,noise=0,length=30 --preset draft --set "
                "lesion.narrow_percent=100",
                65, "a balloon crosses a lumen of at least 0.24 mm"},
        Refusal{"LesionAtTheInlet", "--preset paper-unilateral --set lesion.abscissa_mm=0", 65,
                "within one lumen diameter of an open end"},
        Refusal{"WrongPreset", "--preset paper-unilaterl", 78, "did you mean paper-unilateral?"},
        Refusal{"AnotherPhantom", "phantom:bilateral --preset paper-unilateral", 64,
                "phantom:unilateral"},
        Refusal{"NoScan", "--preset paper-coronary-3dra", 64, "needs an INPUT"},
        Refusal{"BalloonLongerThanTheVessel",
                "--preset paper-unilateral --set balloon.length_mm=80", 0,
                "the balloon was shortened from 80.00 mm"}));

TEST(ClearEnds, AThreefoldBalloonAboveItsRatedBurstRunsAndIsWarnedOfInTheReport) {
  CommandFolder folder;
  const ProgramResult run =
      run_program("run --preset paper-unilateral -o '" + folder / "c" + "'" + kQuick +
                  " balloon.nominal_diameter_mm=9 balloon.rest_diameter_mm=9 balloon.material=pa12 "
                  "balloon.membrane=automatic inflation.rated_burst_atm=0.5");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  const std::string report = file_text(folder.path() / "c/report/index.html");
  EXPECT_NE(report.find("rated burst pressure"), std::string::npos);
  EXPECT_NE(report.find("times the vessel"), std::string::npos);
  // What the balloon does to the vessel is told before what the solver says of itself.
  const json stages = read_json_file(folder.path() / "c/run.json").at("stages");
  const std::string told = stages.at("simulation").at("warnings").dump();
  EXPECT_LT(told.find("beside the lesion the balloon widens"), told.find("rated burst pressure"));
  EXPECT_LT(told.find("rated burst pressure"), told.find("off balance"));
  EXPECT_EQ(read_json_file(folder.path() / "c/metrics.json")
                .at("simulation")
                .at("max_penetration_mm")
                .get<double>(),
            0.0);
}

}  // namespace
}  // namespace angio::test

// The whole way, on phantoms whose truth is known: DICOM or surface in, report out.

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "datasets/phantom.hpp"
#include "meshing/meshing.hpp"
#include "pipeline/case_files.hpp"
#include "run_program.hpp"
#include "viewer/files.hpp"

namespace angio::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json read_json_file(const fs::path& file) { return json::parse(file_text(file)); }

std::vector<fs::path> files_under(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(fs::relative(entry.path(), folder));
  std::sort(files.begin(), files.end());
  return files;
}

void expect_no_surface_crosses(const fs::path& case_folder) {
  int frames = 0;
  for (const fs::path& file : files_under(case_folder / "simulation/frames")) {
    const std::string name = file.filename().string();
    if (!name.starts_with("balloon_")) continue;
    const int frame = std::stoi(name.substr(8, 6));
    const auto shape = pipeline::read_frame(case_folder / "simulation/frames", frame);
    EXPECT_EQ(meshing::count_intersections(shape.balloon, shape.wall), 0) << name;
    ++frames;
  }
  EXPECT_GE(frames, 3);
}

void expect_sound_lumen(const fs::path& case_folder) {
  const TriangleMesh capped = viewer::read_surface(case_folder / "meshing/lumen_capped.stl").mesh;
  const SurfaceTopology topology = surface_topology(capped);
  EXPECT_TRUE(topology.is_closed());
  EXPECT_EQ(topology.component_count, 1);
  EXPECT_EQ(meshing::count_self_intersections(capped), 0);
  const json mesh = read_json_file(case_folder / "metrics.json").at("mesh");
  EXPECT_TRUE(mesh.at("watertight").get<bool>());
  EXPECT_EQ(mesh.at("self_intersections").get<int>(), 0);
}

/// Mean relative error of the inscribed radius and mean distance of the line, over the truth's
/// points away from the vessels' ends (lines end a little before the vessel does).
struct RadiusError {
  double mean = 0.0;
  double mean_distance_mm = 0.0;
};
RadiusError radius_error(const CenterlineTree& found, const CenterlineTree& truth) {
  RadiusError error;
  int count = 0;
  for (const CenterlinePath& path : truth.paths) {
    const double length = path.abscissa.back();
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const double margin = 2.0 * path.inscribed_radius[i];
      if (path.abscissa[i] < margin || path.abscissa[i] > length - margin) continue;
      double best = 1e9;
      double radius = 0.0;
      for (const CenterlinePath& line : found.paths) {
        const CenterlineSample at = sample(line, project(line, path.points[i]));
        const double d = distance(at.point, path.points[i]);
        if (d < best) {
          best = d;
          radius = at.inscribed_radius;
        }
      }
      error.mean += std::abs(radius - path.inscribed_radius[i]) / path.inscribed_radius[i];
      error.mean_distance_mm += best;
      ++count;
    }
  }
  error.mean /= count;
  error.mean_distance_mm /= count;
  return error;
}

class StenosedPhantom : public testing::TestWithParam<const char*> {};

TEST_P(StenosedPhantom, IsMeasuredAndDilatedFromDicom) {
  TemporaryFolder folder;
  const std::string name = GetParam();
  ASSERT_EQ(run_program("phantom " + name + " --stenosis 60 --noise 0.1 --seed 3 -o '" +
                        folder / "phantom" + "'")
                .exit_code,
            0);
  const ProgramResult run = run_program("run '" + folder / "phantom/dicom" + "' -o '" +
                                        folder / "case" + "' --set simulation.write_every=20");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  EXPECT_NE(run.out.find("report/index.html"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder.path() / "case/report/index.html"));

  datasets::PhantomOptions options;
  options.name = name;
  options.stenosis_percent = 60.0;
  const datasets::PhantomTruth truth = datasets::make_phantom_surface(options).truth;
  const json metrics = read_json_file(folder.path() / "case/metrics.json");
  const CenterlineTree tree =
      pipeline::read_centerlines(folder.path() / "case/centerline/centerlines.vtp");

  const RadiusError error = radius_error(tree, truth.tree);
  std::cout << name << ": lines " << tree.paths.size() << " of " << truth.tree.paths.size()
            << ", radius error " << 100.0 * error.mean << " %, distance " << error.mean_distance_mm
            << " mm, MLD " << metrics.at("lesion").at("mld_mm") << " mm (true " << truth.mld_mm
            << "), after " << metrics.at("result").at("mld_mm") << " mm, recoil "
            << metrics.at("result").at("recoil_percent") << " %\n";
  EXPECT_EQ(tree.paths.size(), truth.tree.paths.size());
  EXPECT_LT(error.mean, 0.08);
  EXPECT_NEAR(metrics.at("lesion").at("mld_mm").get<double>(), truth.mld_mm, 0.25);
  expect_sound_lumen(folder.path() / "case");
  EXPECT_GT(metrics.at("result").at("mld_mm").get<double>(),
            metrics.at("lesion").at("mld_mm").get<double>());
  EXPECT_EQ(metrics.at("simulation").at("max_penetration_mm").get<double>(), 0.0);
  expect_no_surface_crosses(folder.path() / "case");
}

INSTANTIATE_TEST_SUITE_P(AllShapes, StenosedPhantom,
                         testing::Values("unilateral", "bilateral", "ytype", "coronary"));

TEST(Run, TheSameCommandTwiceGivesTheSameBytes) {
  TemporaryFolder folder;
  const std::string run = "run phantom:unilateral,length=24,stenosis=50 --preset draft -o ";
  ASSERT_EQ(run_program(run + "'" + folder / "a" + "'").exit_code, 0);
  ASSERT_EQ(run_program(run + "'" + folder / "b" + "' --threads 1").exit_code, 0);
  const std::vector<fs::path> files = files_under(folder.path() / "a");
  EXPECT_EQ(files, files_under(folder.path() / "b"));
  for (const fs::path& file : files) {
    if (file == "run.json" || file == "metrics.json") continue;  // they hold times
    EXPECT_EQ(file_text(folder.path() / "a" / file), file_text(folder.path() / "b" / file)) << file;
  }
}

TEST(Run, GoesOnWhereItStoppedAndRepeatsOnlyWhatChanged) {
  TemporaryFolder folder;
  const std::string run =
      "run phantom:straight,length=20,noise=0.05 --preset draft -o '" + folder / "c" + "' ";
  ASSERT_EQ(run_program(run + "--until centerline").exit_code, 0);
  EXPECT_FALSE(fs::exists(folder.path() / "c/meshing"));
  const ProgramResult second = run_program(run + "--until meshing");
  ASSERT_EQ(second.exit_code, 0) << second.error;
  EXPECT_NE(second.error.find("segmentation  up to date"), std::string::npos) << second.error;
  EXPECT_NE(second.error.find("no stenosis"), std::string::npos) << second.error;
  const ProgramResult third =
      run_program(run +
                  "--until meshing --set balloon.length_mm=8 lesion.centerline=0 "
                  "lesion.abscissa_mm=10");
  ASSERT_EQ(third.exit_code, 0) << third.error;
  EXPECT_NE(third.error.find("centerline    up to date"), std::string::npos) << third.error;
  EXPECT_NE(third.error.find("meshing       done"), std::string::npos) << third.error;
  const json lesion = read_json_file(folder.path() / "c/metrics.json").at("lesion");
  EXPECT_NEAR(lesion.at("abscissa_mm").get<double>(), 10.0, 1e-9);
}

TEST(Run, ALumenSurfaceBeginsAtTheCenterline) {
  TemporaryFolder folder;
  ASSERT_EQ(
      run_program("phantom unilateral --format surface --stenosis 50 -o '" + folder / "p" + "'")
          .exit_code,
      0);
  const ProgramResult run =
      run_program("run '" + folder / "p/lumen.stl" + "' --preset draft -o '" + folder / "c" + "'");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  EXPECT_FALSE(fs::exists(folder.path() / "c/segmentation/lumen_mask.nrrd"));
  const json metrics = read_json_file(folder.path() / "c/metrics.json");
  EXPECT_NEAR(metrics.at("lesion").at("diameter_stenosis_percent").get<double>(), 50.0, 5.0);
}

TEST(Run, TheWallCanBeASolidOfLayers) {
  TemporaryFolder folder;
  ASSERT_EQ(run_program("phantom unilateral --format surface --length 16 --stenosis 50 -o '" +
                        folder / "p" + "'")
                .exit_code,
            0);
  const ProgramResult run =
      run_program("run '" + folder / "p/lumen.stl" + "' --preset draft -o '" + folder / "c" +
                  "' --set wall.model=layered balloon.length_mm=4 inflation.inflate_s=0.15 "
                  "inflation.hold_s=0 inflation.deflate_s=0.1 inflation.rest_s=0");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  const json metrics = read_json_file(folder.path() / "c/metrics.json");
  const json& regions = metrics.at("wall").at("regions");
  for (const char* region : {"intima", "media", "adventitia", "plaque"})
    EXPECT_GT(regions.at(region).at("peak_principal_stress_median_kpa").get<double>(), 0.0);

  const fs::path frames = folder.path() / "c/simulation/frames";
  const auto wall = viewer::read_wedges(frames / "wall_000000.vtu");
  const auto lumen = viewer::read_surface(frames / "vessel_000000.vtp").mesh;
  ASSERT_GT(wall.points.size(), lumen.vertices.size());
  EXPECT_TRUE(std::equal(lumen.vertices.begin(), lumen.vertices.end(), wall.points.begin()));
  for (const double j : viewer::find_array(wall.cell_arrays, "volume_ratio").values)
    EXPECT_NEAR(j, 1.0, 0.05);
}

TEST(Batch, GoesOnPastAFailureAndSumsUp) {
  TemporaryFolder folder;
  std::ofstream(folder / "m.csv") << "case,input,balloon.length_mm\n"
                                  << "good,\"phantom:straight,length=20,noise=0\",8\n"
                                  << "bad,missing.nrrd,\n";
  const std::string batch =
      "batch '" + folder / "m.csv" + "' -j 2 --preset draft -o '" + folder / "out" + "'";
  const ProgramResult result = run_program(batch);
  EXPECT_EQ(result.exit_code, 2) << result.error;
  const std::string summary = file_text(folder.path() / "out/summary.csv");
  EXPECT_NE(summary.find("good,done,0"), std::string::npos) << summary;
  EXPECT_NE(summary.find("bad,failed,66"), std::string::npos) << summary;
  EXPECT_TRUE(fs::exists(folder.path() / "out/good/report/index.html"));
  EXPECT_EQ(run_program(batch + " --resume").exit_code, 2);
}

}  // namespace
}  // namespace angio::test

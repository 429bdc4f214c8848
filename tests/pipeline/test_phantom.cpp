// The whole way, on phantoms whose truth is known: DICOM or surface in, report out.

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "datasets/phantom.hpp"
#include "formats/files.hpp"
#include "meshing/meshing.hpp"
#include "pipeline/case/case_files.hpp"
#include "run_program.hpp"
#include "testing/pipeline/case_content.hpp"

namespace angio::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

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
  const TriangleMesh capped = formats::read_surface(case_folder / "meshing/lumen_capped.stl").mesh;
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
  CommandFolder folder;
  const std::string name = GetParam();
  ASSERT_EQ(run_program("phantom " + name + " --stenosis 60 --noise 0.1 --seed 3 -o '" +
                        folder / "phantom" + "'")
                .exit_code,
            0);
  const ProgramResult run = run_program("run '" + folder / "phantom/dicom" + "' -o '" +
                                        folder / "case" + "' --preset draft");
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

INSTANTIATE_TEST_SUITE_P(AllShapes, StenosedPhantom, testing::Values("bilateral", "coronary"));

TEST(Run, TheSameCommandTwiceGivesTheSameBytes) {
  CommandFolder folder;
  const std::string run =
      "run phantom:unilateral,length=14,stenosis=50 --preset draft --set balloon.length_mm=5 "
      "inflation.inflate_s=0.2 inflation.hold_s=0 inflation.deflate_s=0.15 inflation.rest_s=0.05 "
      "-o ";
  ASSERT_EQ(run_program(run + "'" + folder / "a" + "'").exit_code, 0);
  ASSERT_EQ(run_program(run + "'" + folder / "b" + "' --threads 1").exit_code, 0);
  const std::vector<fs::path> files = files_under(folder.path() / "a");
  EXPECT_EQ(files, files_under(folder.path() / "b"));
  for (const fs::path& file : files) {
    if (file == "run.json" || file == "metrics.json") continue;  // they hold times
    EXPECT_EQ(file_text(folder.path() / "a" / file), file_text(folder.path() / "b" / file)) << file;
  }
}

/// `angio run` of a small vessel, quick and coarse. The first setting follows this.
const std::string kSmallRun =
    "run phantom:unilateral,length=10,stenosis=50,noise=0 --preset draft --quiet --set "
    "balloon.length_mm=3 balloon.ring_count=6 balloon.ring_vertex_count=8 simulation.sweeps=20 "
    "mesh.edges_per_circumference=8 inflation.inflate_s=0.1 inflation.hold_s=0 "
    "inflation.deflate_s=0.1 inflation.rest_s=0 volume.fill=false ";

/// What the stages have come to, in run.json.
std::string status_of(const fs::path& folder, const char* stage) {
  return read_json_file(folder / "run.json").at("stages").at(stage).at("status");
}

double seconds_of(const fs::path& folder, const char* stage) {
  return read_json_file(folder / "run.json").at("stages").at(stage).at("seconds");
}

TEST(Run, GoesOnWhereItStoppedAndRepeatsOnlyWhatChanged) {
  CommandFolder folder;
  const fs::path root = folder.path() / "c";
  const auto run = [&](const std::string& more) {
    const ProgramResult result = run_program(kSmallRun + more + " -o '" + root.string() + "'");
    ASSERT_EQ(result.exit_code, 0) << result.error;
  };
  run("--until centerline");
  EXPECT_FALSE(fs::exists(root / "meshing"));
  const double segmentation = seconds_of(root, "segmentation"),
               centerline = seconds_of(root, "centerline");
  run("--until meshing");
  EXPECT_EQ(seconds_of(root, "segmentation"), segmentation);
  EXPECT_EQ(seconds_of(root, "centerline"), centerline);
  const double meshing = seconds_of(root, "meshing");
  run("lesion.centerline=0 lesion.abscissa_mm=5.6 --until meshing");
  EXPECT_EQ(seconds_of(root, "centerline"), centerline);
  EXPECT_NE(seconds_of(root, "meshing"), meshing);
  const json lesion = read_json_file(root / "metrics.json").at("lesion");
  EXPECT_NEAR(lesion.at("abscissa_mm").get<double>(), 5.6, 1e-9);
  const double meshing_there = seconds_of(root, "meshing");
  run("lesion.centerline=0 lesion.abscissa_mm=5.6 centerline.step_mm=0.4 --until meshing");
  EXPECT_EQ(seconds_of(root, "segmentation"), segmentation);
  EXPECT_NE(seconds_of(root, "centerline"), centerline) << "its own setting";
  EXPECT_NE(seconds_of(root, "meshing"), meshing_there) << "an earlier stage's setting";
}

/// Settings that more than one stage reads, by the configuration or by another stage's files.
class ChangedSetting : public testing::TestWithParam<const char*> {};

TEST_P(ChangedSetting, GivesTheCaseThatWouldHaveBeenFromTheStart) {
  CommandFolder folder;
  const std::string until = " --until simulation -o '", setting = GetParam();
  ASSERT_EQ(run_program(kSmallRun + "guidewire.model=rod" + until + folder / "c" + "'").exit_code,
            0);
  const auto before = case_content(folder.path() / "c");
  const std::string changed = kSmallRun + "guidewire.model=rod " + setting + until;
  ASSERT_EQ(run_program(changed + folder / "c" + "'").exit_code, 0);
  ASSERT_EQ(run_program(changed + folder / "fresh" + "'").exit_code, 0);
  const auto resumed = case_content(folder.path() / "c"),
             fresh = case_content(folder.path() / "fresh");
  EXPECT_NE(fresh.at("simulation/timeseries.csv") + fresh.at("centerline/lesions.json"),
            before.at("simulation/timeseries.csv") + before.at("centerline/lesions.json"))
      << "the setting counts for nothing here";
  ASSERT_EQ(resumed.size(), fresh.size());
  for (const auto& [file, text] : fresh) EXPECT_TRUE(resumed.at(file) == text) << file;
}

INSTANTIATE_TEST_SUITE_P(Settings, ChangedSetting,
                         testing::Values("wall.model=shape_matching", "wall.thickness_ratio=0.25",
                                         "balloon.shaft_diameter_mm=0.5 balloon.folds=0",
                                         "lesion.min_stenosis_percent=70"));

TEST(Run, WhatIsStaleLeavesTheCaseUntilItIsMadeAgain) {
  CommandFolder folder;
  const fs::path root = folder.path() / "c";
  const std::string to = " -o '" + root.string() + "'", notice = "This report is stale.";
  ASSERT_EQ(run_program(kSmallRun + to).exit_code, 0);
  const auto before = case_content(root);
  EXPECT_EQ(before.at("report/index.html").find(notice), std::string::npos);
  ASSERT_EQ(
      run_program(kSmallRun + "lesion.centerline=0 lesion.abscissa_mm=5.5 --until meshing" + to)
          .exit_code,
      0);
  const json metrics = read_json_file(root / "metrics.json");
  EXPECT_NEAR(metrics.at("lesion").at("abscissa_mm").get<double>(), 5.5, 1e-9);
  EXPECT_EQ(metrics.at("status"), "stale");
  for (const char* group : {"result", "simulation"})
    for (const auto& value : metrics.at(group)) EXPECT_TRUE(value.is_null()) << group;
  EXPECT_TRUE(metrics.at("balloon").at("peak_diameter_mm").is_null());
  EXPECT_EQ(status_of(root, "meshing"), "done");
  EXPECT_EQ(status_of(root, "simulation"), "stale");
  EXPECT_EQ(status_of(root, "report"), "stale");
  EXPECT_NE(file_text(root / "report/index.html").find(notice), std::string::npos);

  const double simulation = seconds_of(root, "simulation");
  ASSERT_EQ(run_program(kSmallRun + to).exit_code, 0);
  EXPECT_EQ(seconds_of(root, "simulation"), simulation) << "it is what it was: not run again";
  EXPECT_TRUE(case_content(root) == before);
}

TEST(Run, AStageAloneRefusesWhatTheOnesBeforeItRead) {
  CommandFolder folder;
  const std::string to = "'" + folder / "c" + "'";
  ASSERT_EQ(run_program(kSmallRun + "--until meshing -o " + to).exit_code, 0);
  for (const char* command :
       {"mesh --set lesion.min_stenosis_percent=40", "mesh --set segmentation.scale_count=3",
        "simulate --set wall.model=shape_matching", "simulate --preset fine",
        "segment --set input.resample=true"})
    EXPECT_EQ(run_program(std::string(command) + " --quiet " + to).exit_code, 64) << command;
  EXPECT_EQ(run_program("mesh " + to + " --quiet --set lesion.centerline=0 lesion.abscissa_mm=5.5")
                .exit_code,
            0);
}

TEST(Run, ALumenSurfaceBeginsAtTheCenterline) {
  CommandFolder folder;
  ASSERT_EQ(
      run_program("phantom unilateral --format surface --stenosis 50 -o '" + folder / "p" + "'")
          .exit_code,
      0);
  const ProgramResult run =
      run_program("run '" + folder / "p/lumen.stl" + "' --until meshing -o '" + folder / "c" + "'");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  EXPECT_FALSE(fs::exists(folder.path() / "c/segmentation/lumen_mask.nrrd"));
  const json metrics = read_json_file(folder.path() / "c/metrics.json");
  EXPECT_NEAR(metrics.at("lesion").at("diameter_stenosis_percent").get<double>(), 50.0, 5.0);
}

TEST(Run, TheWallCanBeASolidOfLayers) {
  CommandFolder folder;
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
  const auto wall = formats::read_wedges(frames / "wall_000000.vtu");
  const auto lumen = formats::read_surface(frames / "vessel_000000.vtp").mesh;
  ASSERT_GT(wall.points.size(), lumen.vertices.size());
  EXPECT_TRUE(std::equal(lumen.vertices.begin(), lumen.vertices.end(), wall.points.begin()));
  for (const double j : formats::find_array(wall.cell_arrays, "volume_ratio").values)
    EXPECT_NEAR(j, 1.0, 0.05);
}

TEST(Batch, GoesOnPastAFailureAndSumsUp) {
  CommandFolder folder;
  std::ofstream(folder / "broken.nrrd") << "NRRD0004\n# cut off\n";
  std::ofstream(folder / "m.csv") << "case,input,balloon.length_mm\n"
                                  << "good,\"phantom:straight,length=20,noise=0\",8\n"
                                  << "bad,broken.nrrd,\n";
  const std::string batch =
      "batch '" + folder / "m.csv" + "' -j 2 --preset draft -o '" + folder / "out" + "'";
  const ProgramResult result = run_program(batch);
  EXPECT_EQ(result.exit_code, 2) << result.error;
  const std::string summary = file_text(folder.path() / "out/summary.csv");
  EXPECT_NE(summary.find("good,done,0"), std::string::npos) << summary;
  EXPECT_NE(summary.find("bad,failed,65"), std::string::npos) << summary;
  EXPECT_TRUE(fs::exists(folder.path() / "out/good/report/index.html"));
}

TEST(Batch, ResumesByContent) {
  CommandFolder folder;
  const auto manifest = [&](const char* length, const char* stenosis = "50") {
    std::ofstream(folder / "m.csv")
        << "case,input,balloon.length_mm\n"
        << "kept,\"phantom:unilateral,length=10,stenosis=50,noise=0\",3\n"
        << "other,\"phantom:unilateral,length=10,stenosis=" << stenosis << ",noise=0\"," << length
        << "\n";
  };
  const std::string options = kSmallRun.substr(kSmallRun.find("--preset"));
  const std::string batch = "batch '" + folder / "m.csv" + "' -o '" + folder / "out" + "' " +
                            options.substr(0, options.find("balloon.length_mm=3")) +
                            options.substr(options.find("balloon.ring_count"));
  manifest("3");
  ASSERT_EQ(run_program(batch).exit_code, 0);
  const fs::path kept = folder.path() / "out/kept", other = folder.path() / "out/other";
  const double first = seconds_of(kept, "report"), second = seconds_of(other, "report");
  ASSERT_EQ(run_program(batch + " --resume").exit_code, 0);
  EXPECT_EQ(seconds_of(other, "report"), second);
  manifest("2");
  ASSERT_EQ(run_program(batch + " --resume").exit_code, 0);
  EXPECT_EQ(seconds_of(kept, "report"), first);
  EXPECT_NE(seconds_of(other, "report"), second);
  EXPECT_EQ(read_json_file(other / "metrics.json").at("balloon").at("length_mm"), 2.0);
  // Another input in the same row.
  manifest("2", "60");
  ASSERT_EQ(run_program(batch + " --resume").exit_code, 0);
  EXPECT_EQ(seconds_of(kept, "report"), first);
  EXPECT_NE(read_json_file(other / "run.json").at("input").at("sha256"),
            read_json_file(kept / "run.json").at("input").at("sha256"));
}

}  // namespace
}  // namespace angio::test

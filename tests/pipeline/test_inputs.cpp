#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "datasets/phantom.hpp"
#include "formats/files.hpp"
#include "testing/shapes.hpp"
#include "tests/pipeline/run_program.hpp"

// What people bring: each way in leads to the same numbers, or to one clear line.
namespace angio::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::CommandFolder;
using test::file_text;
using test::ProgramResult;
using test::run_program;

constexpr const char* kSmallPhantom =
    "phantom concentric --length 20 --spacing 0.4 --noise 0.05 --oblique 20 ";

std::string point_line(const std::string& kind, const Vec3& v) {
  char text[96];
  std::snprintf(text, sizeof text, "%s %.9g %.9g %.9g\n", kind.c_str(), v.x, v.y, v.z);
  return text;
}

json lesions_of(const fs::path& case_folder) {
  return json::parse(file_text(case_folder / "centerline/lesions.json"));
}

TEST(Inputs, CtSeriesAndXRay3DGiveTheSameLumen) {
  CommandFolder folder;
  ASSERT_EQ(run_program(std::string(kSmallPhantom) + "-o '" + folder / "ct" + "'").exit_code, 0);
  ASSERT_EQ(run_program(std::string(kSmallPhantom) + "--format xray3d -o '" + folder / "x3" + "'")
                .exit_code,
            0);
  for (const char* kind : {"ct", "x3"}) {
    const ProgramResult run = run_program(
        "run '" + folder / kind + "/dicom' --until centerline -o '" + folder / kind + "_case'");
    ASSERT_EQ(run.exit_code, 0) << run.error;
  }
  for (const char* file : {"segmentation/lumen_level_set.nrrd", "centerline/centerlines.vtp"})
    EXPECT_EQ(file_text(folder.path() / "ct_case" / file),
              file_text(folder.path() / "x3_case" / file))
        << file;
  const json lesions = lesions_of(folder.path() / "ct_case");
  ASSERT_EQ(lesions.size(), 1u);
  EXPECT_NEAR(lesions[0].at("mld_mm").get<double>(), 1.2, 0.12);
  // Five millimetres of healthy vessel on either side: a line through them is 4 % uncertain.
  EXPECT_NEAR(lesions[0].at("reference_interpolated_mm").get<double>(), 3.0, 0.1);
  EXPECT_NEAR(lesions[0].at("reference_average_mm").get<double>(), 3.0, 0.1);
  EXPECT_NEAR(lesions[0].at("area_stenosis_percent").get<double>(), 84.0, 4.0);
}

TEST(Inputs, WhatLinksACaseToItsSourceIsWrittenOnRequestOnlyAndForItsOwnerOnly) {
  CommandFolder folder;
  ASSERT_EQ(run_program(std::string(kSmallPhantom) + "-o '" + folder / "ct" + "'").exit_code, 0);
  const std::string run =
      "run '" + folder / "ct" + "/dicom' --until segmentation -o '" + folder / "case" + "' ";
  ASSERT_EQ(run_program(run).exit_code, 0);
  for (const char* file : {"source.private.json", "segmentation.private.dcm"})
    EXPECT_FALSE(fs::exists(folder.path() / "case" / file)) << file;
  ASSERT_EQ(run_program(run + "--keep-link").exit_code, 0);
  for (const char* file : {"source.private.json", "segmentation.private.dcm"}) {
    struct stat status {};
    ASSERT_EQ(::stat((folder.path() / "case" / file).c_str(), &status), 0) << file;
    EXPECT_EQ(status.st_mode & 0777, 0600u) << file;
  }
}

TEST(Inputs, ASurfaceInMetresIsKnownAndTold) {
  CommandFolder folder;
  TriangleMesh mesh = datasets::make_phantom_surface(datasets::parse_phantom("unilateral")).surface;
  for (Vec3& vertex : mesh.vertices) vertex *= 1e-3;
  std::string text = "# exported elsewhere\n";
  for (const Vec3& v : mesh.vertices) text += point_line("v", v);
  for (const Triangle& t : mesh.triangles)
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
            std::to_string(t[2] + 1) + "\n";
  std::ofstream(folder / "metres.obj") << text;
  const std::string run = "run '" + folder / "metres.obj" + "' -o '" + folder / "case" + "' ";
  const ProgramResult guessed = run_program(run + "--until centerline");
  ASSERT_EQ(guessed.exit_code, 0) << guessed.error;
  EXPECT_NE(guessed.error.find("read in m:"), std::string::npos) << guessed.error;
  EXPECT_NE(guessed.error.find("--unit"), std::string::npos) << guessed.error;
  EXPECT_NEAR(lesions_of(folder.path() / "case")[0].at("mld_mm").get<double>(), 1.2, 0.02);
  // A wrong unit by hand is refused by name.
  const ProgramResult refused = run_program(run + "--until segmentation --unit mm --force");
  EXPECT_EQ(refused.exit_code, 65);
  EXPECT_EQ(refused.error_line_count(), 1) << refused.error;
  EXPECT_NE(refused.error.find("--unit m"), std::string::npos) << refused.error;
}

TEST(Inputs, ASurfaceIsInspectedWithItsSizes) {
  CommandFolder folder;
  const TriangleMesh tube = tests::make_tube(1.5, 40.0, 81, 32);
  formats::write_surface(folder.path() / "tube.ply", {tube, {}, {}});
  const ProgramResult inspected = run_program("inspect --json '" + folder / "tube.ply" + "'");
  ASSERT_EQ(inspected.exit_code, 0) << inspected.error;
  const json found = json::parse(inspected.out);
  EXPECT_EQ(found.at("unit"), "mm");
  EXPECT_EQ(found.at("unit_source"), "file");
  EXPECT_FALSE(found.at("closed").get<bool>());
  EXPECT_EQ(found.at("self_intersections"), 0);
  EXPECT_NEAR(found.at("median_diameter_mm").get<double>(), 3.0, 0.15);
  EXPECT_NEAR(found.at("volume_mm3").get<double>(), 3.1416 * 2.25 * 40.0, 3.0);
  ASSERT_EQ(found.at("open_ends").size(), 2u);
  EXPECT_NEAR(found.at("open_ends")[0].at("diameter_mm").get<double>(), 3.0, 0.05);
  EXPECT_TRUE(found.at("repairs").empty());
}

TEST(Inputs, ABrokenSurfaceIsRepairedAndEveryRepairTold) {
  CommandFolder folder;
  TriangleMesh mesh = datasets::make_phantom_surface(datasets::parse_phantom("unilateral")).surface;
  mesh.triangles.erase(mesh.triangles.begin() + 500, mesh.triangles.begin() + 504);  // a hole
  for (std::size_t t = 1000; t < 1010; ++t) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  formats::write_surface(folder.path() / "broken.ply", {mesh, {}, {}});
  const ProgramResult run = run_program("run '" + folder / "broken.ply" +
                                        "' --until centerline -o '" + folder / "case" + "'");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  EXPECT_NE(run.error.find("repaired: "), std::string::npos) << run.error;
  EXPECT_NEAR(lesions_of(folder.path() / "case")[0].at("mld_mm").get<double>(), 1.2, 0.02);
}

TEST(Inputs, TheLumenIsFilledWithTetrahedraThatKnowTheirBoundary) {
  CommandFolder folder;
  const ProgramResult run =
      run_program("run phantom:ytype,noise=0.05 --until meshing -o '" + folder / "case" + "'");
  ASSERT_EQ(run.exit_code, 0) << run.error;
  const formats::TetData lumen = formats::read_tets(folder.path() / "case/meshing/lumen.vtu");
  EXPECT_GT(lumen.mesh.tets.size(), 1000u);
  std::set<double> on_boundary;
  const auto& ids = formats::find_array(lumen.cell_arrays, "CellEntityIds").values;
  ASSERT_EQ(ids.size(), lumen.mesh.tets.size() + lumen.boundary.size());
  for (std::size_t c = 0; c < ids.size(); ++c) {
    if (c < lumen.mesh.tets.size())
      ASSERT_EQ(ids[c], 0.0);
    else
      on_boundary.insert(ids[c]);
  }
  EXPECT_EQ(on_boundary, (std::set<double>{1, 2, 3, 4}));  // wall, inlet, two outlets
  const json mesh = json::parse(file_text(folder.path() / "case/metrics.json")).at("mesh");
  EXPECT_EQ(mesh.at("tets").get<std::size_t>(), lumen.mesh.tets.size());
  EXPECT_GE(mesh.at("min_dihedral_degrees").get<double>(), 12.0);
  EXPECT_GE(mesh.at("min_angle_off_rims_degrees").get<double>(), 20.0);
}

/// How much longer the lumen's edges are along the vessel than around it, within a millimetre of
/// the balloon's place, root mean squares.
double length_along_over_around(const std::filesystem::path& case_folder) {
  const json site = json::parse(file_text(case_folder / "meshing/placement.json")).at("site");
  const auto vector_of = [&](const char* key) {
    const json& v = site.at(key);
    return Vec3{v[0].get<double>(), v[1].get<double>(), v[2].get<double>()};
  };
  const Vec3 throat = vector_of("point"), tangent = vector_of("tangent");
  const TriangleMesh lumen = formats::read_surface(case_folder / "meshing/lumen.vtp").mesh;
  double along = 0.0, all = 0.0;
  for (const auto& [a, b] : unique_edges(lumen)) {
    const Vec3 p = lumen.vertices[std::size_t(a)], edge = lumen.vertices[std::size_t(b)] - p;
    if (distance(p, throat) > 1.0) continue;
    along += dot(edge, tangent) * dot(edge, tangent);
    all += norm_squared(edge);
  }
  return std::sqrt(along / (all - along));
}

// A balloon of 3 mm opens the throat of 1.2 mm by 2.5: half way to it edges are 1.6 times as long
// along the vessel, with what remeshing leaves 1.25; even ones are 1.
TEST(Inputs, AThroatIsMeshedForTheBalloonUnlessALengthIsAskedFor) {
  CommandFolder folder;
  const std::string run =
      "run phantom:concentric,stenosis=60,noise=0 --until meshing --set "
      "volume.fill=false ";
  const ProgramResult usual = run_program(run + "-o '" + folder / "usual" + "'");
  ASSERT_EQ(usual.exit_code, 0) << usual.error;
  EXPECT_GT(length_along_over_around(folder.path() / "usual"), 1.15);
  const ProgramResult even =
      run_program(run + "mesh.edge_length_mm=0.25 -o '" + folder / "even" + "'");
  ASSERT_EQ(even.exit_code, 0) << even.error;
  EXPECT_NEAR(length_along_over_around(folder.path() / "even"), 1.0, 0.1);
}

TEST(Inputs, AProjectionRunIsDescribed) {
  const char* data = std::getenv("ANGIO_DATA");
  if (data == nullptr) GTEST_SKIP() << "ANGIO_DATA is not set";
  const std::string run = std::string("'") + data + "/dicom-traps/xa_frametime.dcm'";
  const ProgramResult described = run_program("inspect --json " + run);
  ASSERT_EQ(described.exit_code, 0) << described.error;
  const json series = json::parse(described.out).at("series").at(0);
  EXPECT_FALSE(series.at("usable").get<bool>());
  EXPECT_NE(series.at("verdict").get<std::string>().find("rotational run"), std::string::npos);
  EXPECT_NEAR(series.at("projection").at("frame_time_ms").get<double>(), 33.33, 0.01);
}

TEST(Inputs, TheInletIsTheEndOrThePointThatOneNames) {
  CommandFolder folder;
  const std::string surface = folder / "tube.ply";
  formats::write_surface(surface, {tests::make_tube(1.5, 40.0, 81, 32), {}, {}});
  const ProgramResult inspected = run_program("inspect --json '" + surface + "'");
  ASSERT_EQ(inspected.exit_code, 0) << inspected.error;
  const json ends = json::parse(inspected.out).at("open_ends");
  ASSERT_EQ(ends.size(), 2u);
  const auto begins_at = [&](const std::string& inlet, const std::string& name) {
    const ProgramResult run = run_program("run '" + surface + "' --until centerline --inlet " +
                                          inlet + " -o '" + folder / name + "'");
    EXPECT_EQ(run.exit_code, 0) << run.error;
    return formats::read_polylines(folder.path() / name / "centerline/paths.vtp").points.front().z;
  };
  for (const int number : {1, 2}) {
    const double z = ends[std::size_t(number - 1)].at("centre_mm")[2].get<double>();
    EXPECT_NEAR(begins_at(std::to_string(number), "end" + std::to_string(number)), z, 0.1);
    EXPECT_NEAR(begins_at("0,0," + std::to_string(z), "point" + std::to_string(number)), z, 0.1);
  }
  const ProgramResult none =
      run_program("run '" + surface + "' --until centerline --inlet 3 -o '" + folder / "n" + "'");
  EXPECT_NE(none.exit_code, 0);
  EXPECT_NE(none.error.find("2 open end"), std::string::npos) << none.error;
}

}  // namespace
}  // namespace angio::pipeline

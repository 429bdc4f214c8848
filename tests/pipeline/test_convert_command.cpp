#include <gtest/gtest.h>

#include "core/atomic_file.hpp"
#include "formats/files.hpp"
#include "formats/nrrd.hpp"
#include "run_program.hpp"

namespace angio::test {
namespace {
namespace fs = std::filesystem;

const TriangleMesh kTetrahedron{{{0.1, 0, 0}, {1, 0, 0}, {0, 1.25, 0}, {0, 0, 1}},
                                {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};

TEST(ConvertCommand, SurfaceGoesRoundAllFormatsUnchanged) {
  CommandFolder folder;
  formats::write_surface(folder.path() / "a.vtp", {kTetrahedron, {}, {}});
  std::string from = folder / "a.vtp";
  for (const char* name : {"b.obj", "c.ply", "d.vtp"}) {
    const ProgramResult result = run_program("convert " + from + " " + (folder / name));
    ASSERT_EQ(result.exit_code, 0) << result.error;
    EXPECT_EQ(result.out, (folder / name) + "\n");
    from = folder / name;
  }
  const auto back = formats::read_surface(from);
  EXPECT_EQ(back.mesh.vertices, kTetrahedron.vertices);
  EXPECT_EQ(back.mesh.triangles, kTetrahedron.triangles);
  ASSERT_EQ(run_program("convert " + from + " " + (folder / "e.stl")).exit_code, 0);
  EXPECT_EQ(formats::read_surface(folder / "e.stl").mesh.triangles.size(), 4u);  // float32
}

TEST(ConvertCommand, CentimetresBecomeMillimetres) {
  CommandFolder folder;
  write_text_atomically(folder / "cm.obj",
                        "# unit=cm\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                        "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  ASSERT_EQ(run_program("convert " + (folder / "cm.obj") + " " + (folder / "mm.ply")).exit_code, 0);
  EXPECT_EQ(formats::read_surface(folder / "mm.ply").mesh.vertices[1], (Vec3{10, 0, 0}));
}

TEST(ConvertCommand, UnitCountsForSurfacesAndVolumes) {
  CommandFolder folder;
  formats::write_surface(folder.path() / "a.ply", {kTetrahedron, {}, {}});
  ASSERT_EQ(
      run_program("convert --unit cm " + (folder / "a.ply") + " " + (folder / "b.ply")).exit_code,
      0);
  EXPECT_EQ(formats::read_surface(folder / "b.ply").mesh.vertices[1], (Vec3{10, 0, 0}));
  VolumeGeometry grid;
  grid.size = {5, 4, 3};
  grid.spacing = {0.5, 0.6, 0.7};
  formats::write_nrrd(folder.path() / "a.nrrd", Volume<float>(grid));
  ASSERT_EQ(
      run_program("convert --unit cm " + (folder / "a.nrrd") + " " + (folder / "b.nrrd")).exit_code,
      0);
  EXPECT_NEAR(formats::read_nrrd(folder / "b.nrrd").geometry.spacing.y, 6.0, 1e-9);
  write_text_atomically(folder.path() / "case" / "run.json", "{}");
  const ProgramResult of_case =
      run_program("convert --unit cm " + (folder / "case") + " " + (folder / "c.glb"));
  EXPECT_EQ(of_case.exit_code, 64);
  EXPECT_EQ(of_case.error_line_count(), 1) << of_case.error;
}

TEST(ConvertCommand, WhatDoesNotFitIsRefusedInOneLine) {
  CommandFolder folder;
  formats::write_surface(folder.path() / "a.vtp", {kTetrahedron, {}, {}});
  for (const auto& [output, code] : {std::pair{"b.nrrd", 64}, {"b.glb", 64}, {"b.xyz", 64}}) {
    const ProgramResult result =
        run_program("convert " + (folder / "a.vtp") + " " + (folder / output));
    EXPECT_EQ(result.exit_code, code) << output;
    EXPECT_EQ(result.error_line_count(), 1) << result.error;
    EXPECT_FALSE(fs::exists(folder / output));
  }
  const ProgramResult missing =
      run_program("convert " + (folder / "none.stl") + " " + (folder / "b.ply"));
  EXPECT_EQ(missing.exit_code, 66);
  EXPECT_EQ(missing.error_line_count(), 1) << missing.error;
}

TEST(ConvertCommand, VolumeKeepsGridAndValues) {
  CommandFolder folder;
  VolumeGeometry grid;
  grid.size = {5, 4, 3};
  grid.spacing = {0.5, 0.6, 0.7};
  grid.origin = {-3, 2, 1};
  Volume<float> volume(grid);
  for (std::size_t i = 0; i < volume.values.size(); ++i) volume.values[i] = float(i) * 0.25F;
  formats::write_nrrd(folder.path() / "a.nrrd", volume);
  const ProgramResult result =
      run_program("convert " + (folder / "a.nrrd") + " " + (folder / "b.nrrd"));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Volume<float> back = formats::read_nrrd(folder / "b.nrrd");
  EXPECT_EQ(back.values, volume.values);
  EXPECT_EQ(back.geometry.size, grid.size);
  EXPECT_NEAR(norm(back.geometry.origin - grid.origin), 0.0, 1e-9);
}

/// As oblique as a C-arm's volume, with axes that run against the patient's.
Volume<float> turned_volume() {
  VolumeGeometry grid;
  grid.size = {5, 4, 3};
  grid.spacing = {0.5, 0.6, 0.7};
  grid.origin = {-3, 2, 1};
  const Vec3 i = normalized(Vec3{-0.9, 0.3, 0.1}), k = normalized(cross(i, Vec3{0.2, -1, 0.3})),
             j = cross(k, i);
  for (int row = 0; row < 3; ++row) {
    grid.direction(row, 0) = i[row];
    grid.direction(row, 1) = j[row];
    grid.direction(row, 2) = k[row];
  }
  Volume<float> volume(grid);
  for (std::size_t v = 0; v < volume.values.size(); ++v) volume.values[v] = float(v) * 0.25F - 3.0F;
  return volume;
}

TEST(ConvertCommand, VolumeComesBackFromMetaImageAndNifti) {
  CommandFolder folder;
  const Volume<float> volume = turned_volume();
  formats::write_nrrd(folder.path() / "a.nrrd", volume);
  for (const auto& [name, tolerance] : {std::pair{"b.mha", 1e-9}, {"b.nii.gz", 1e-5}}) {
    SCOPED_TRACE(name);
    ProgramResult result = run_program("convert " + (folder / "a.nrrd") + " " + (folder / name));
    ASSERT_EQ(result.exit_code, 0) << result.error;
    result = run_program("convert " + (folder / name) + " " + (folder / "c.nrrd"));
    ASSERT_EQ(result.exit_code, 0) << result.error;
    const Volume<float> back = formats::read_nrrd(folder / "c.nrrd");
    ASSERT_EQ(back.geometry.size, volume.geometry.size);
    EXPECT_EQ(back.values, volume.values);
    for (const Vec3& index : {Vec3{0, 0, 0}, Vec3{4, 0, 0}, Vec3{0, 3, 0}, Vec3{1, 2, 2}})
      EXPECT_LT(
          distance(back.geometry.lps_from_index(index), volume.geometry.lps_from_index(index)),
          tolerance * 10.0);
  }
}

TEST(ConvertCommand, SlicerGetsTheMaskOnItsGridAndRadii) {
  CommandFolder folder;
  VolumeGeometry grid;
  grid.size = {4, 3, 2};
  grid.spacing = {0.5, 0.6, 0.7};
  grid.origin = {-3, 2, 1};
  formats::write_nrrd(folder.path() / "case/segmentation/volume.nrrd", Volume<float>(grid));
  // The mask's grid is twice as fine, and begins a voxel of the volume later.
  VolumeGeometry fine = grid;
  fine.size = {5, 5, 3};
  fine.spacing = 0.5 * grid.spacing;
  fine.origin = grid.lps_from_index({1, 0, 0});
  Volume<std::uint8_t> mask(fine);
  mask.at(0, 4, 2) = mask.at(4, 0, 0) = 1;
  mask.at(1, 1, 1) = 1;  // between the volume's voxels
  Volume<std::uint8_t> wanted(grid);
  wanted.at(1, 2, 1) = wanted.at(3, 0, 0) = 1;
  formats::write_nrrd(folder.path() / "case/segmentation/lumen_mask.nrrd", mask);
  const std::vector<double> radii{1.5, 1.0};
  formats::write_polylines(folder.path() / "case/centerline/centerlines.vtp",
                           {{{0, 0, 0}, {0, 0, 5}},
                            {{0, 1}},
                            {{"MaximumInscribedSphereRadius", radii, 1, ArrayType::float64}},
                            {}});
  write_text_atomically(folder / "case/run.json", "{}");
  const ProgramResult result =
      run_program("convert " + (folder / "case") + " " + (folder / "out") + " --to slicer");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Volume<float> back = formats::read_nrrd(folder / "out/lumen.seg.nrrd");
  EXPECT_EQ(back.geometry, grid);
  for (std::size_t i = 0; i < wanted.values.size(); ++i)
    EXPECT_EQ(back.values[i], float(wanted.values[i])) << i;
  const std::string text = file_text(folder / "out/lumen.seg.nrrd");
  const std::string header = text.substr(0, text.find("\n\n"));
  for (const char* line :
       {"Segment0_ID:=Segment_1", "Segment0_Name:=lumen", "Segment0_LabelValue:=1",
        "Segment0_Layer:=0", "Segment0_Extent:=0 3 0 2 0 1",
        "Segmentation_MasterRepresentation:=Binary labelmap"})
    EXPECT_NE(header.find(std::string("\n") + line), std::string::npos) << line;
  const auto lines = formats::read_polylines(folder / "out/centerlines.vtp");
  EXPECT_EQ(formats::find_array(lines.point_arrays, "Radius").values, radii);

  fs::remove(folder / "case/segmentation/lumen_mask.nrrd");
  const ProgramResult refused =
      run_program("convert " + (folder / "case") + " " + (folder / "none") + " --to slicer");
  EXPECT_EQ(refused.exit_code, 66);
  EXPECT_EQ(refused.error_line_count(), 1) << refused.error;
  EXPECT_FALSE(fs::exists(folder / "none"));
}

}  // namespace
}  // namespace angio::test

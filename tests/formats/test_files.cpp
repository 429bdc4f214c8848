#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/tet_mesh.hpp"
#include "formats/files.hpp"
#include "testing/viewer/shapes.hpp"
#include "tests/formats/expectations.hpp"

namespace angio::formats {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;
using viewer::test::make_cube;
using viewer::test::TemporaryFolder;

/// Numbers that float cannot hold, so that a float in between would show.
std::vector<double> make_values(std::size_t count) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(std::sin(double(i) + 0.1) / 3.0);
  return values;
}

std::vector<DataArray> make_arrays(std::size_t count) {
  DataArray lengths{"MaximumInscribedSphereRadius", make_values(count), 1, ArrayType::float64};
  DataArray moves{"displacement", make_values(3 * count), 3, ArrayType::float64};
  DataArray floats{"contact_pressure", {}, 1, ArrayType::float32};
  DataArray ids{"GroupIds", {}, 1, ArrayType::int32};
  DataArray flags{"Blanking", {}, 1, ArrayType::uint8};
  for (std::size_t i = 0; i < count; ++i) {
    floats.values.push_back(double(0.1f * float(i)));
    ids.values.push_back(double(i) - 70000.0);
    flags.values.push_back(double(i % 256));
  }
  return {lengths, moves, floats, ids, flags};
}

SurfaceData make_surface() {
  SurfaceData data;
  data.mesh = make_cube({1.0 / 3.0, -100.1, 1e-7});
  data.point_arrays = make_arrays(data.mesh.vertices.size());
  data.cell_arrays = make_arrays(data.mesh.triangles.size());
  return data;
}

TEST(Vtp, SurfaceComesBackExactlyWithEveryArrayType) {
  const TemporaryFolder folder;
  const SurfaceData data = make_surface();
  write_surface(folder / "a.vtp", data);
  const SurfaceData back = read_surface(folder / "a.vtp");
  expect_equal(back.mesh, data.mesh);
  expect_equal(back.point_arrays, data.point_arrays);
  expect_equal(back.cell_arrays, data.cell_arrays);
}

TEST(Vtp, PolylinesComeBackExactlyAndMayShareThePoints) {
  const TemporaryFolder folder;
  PolylineData data;
  for (int i = 0; i < 9; ++i) data.points.push_back({i / 7.0, i * i / 3.0, -i / 11.0});
  data.lines = {{0, 1, 2, 3, 4, 5, 6, 7, 8}, {0, 1, 5}};
  data.point_arrays = make_arrays(9);
  data.cell_arrays = make_arrays(2);
  write_polylines(folder / "a.vtp", data);
  const PolylineData back = read_polylines(folder / "a.vtp");
  EXPECT_EQ(back.points, data.points);
  EXPECT_EQ(back.lines, data.lines);
  expect_equal(back.point_arrays, data.point_arrays);
  expect_equal(back.cell_arrays, data.cell_arrays);
}

TEST(Vtu, TetrahedraComeBackExactlyAndKeepTheirVolume) {
  const TemporaryFolder folder;
  TetData data;
  data.mesh.vertices = {{0, 0, 0}, {1.0 / 3, 0, 0}, {0, 1.0 / 7, 0}, {0, 0, 2.1}, {1, 1, 1}};
  data.mesh.tets = {{0, 1, 2, 3}, {1, 2, 3, 4}};
  data.point_arrays = make_arrays(5);
  data.cell_arrays = make_arrays(2);
  write_tets(folder / "a.vtu", data);
  const TetData back = read_tets(folder / "a.vtu");
  EXPECT_EQ(back.mesh.vertices, data.mesh.vertices);
  EXPECT_EQ(back.mesh.tets, data.mesh.tets);
  const auto& v = back.mesh.vertices;
  EXPECT_GT(tet_volume(v[0], v[1], v[2], v[3]), 0.0);
  expect_equal(back.point_arrays, data.point_arrays);
  expect_equal(back.cell_arrays, data.cell_arrays);
}

TEST(Files, WedgesReadBackAsTheyWereWritten) {
  const TemporaryFolder folder;
  WedgeData data;
  data.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1.0 / 3.0, 1, 1}};
  data.wedges = {{0, 1, 2, 3, 4, 5}};
  data.point_arrays = make_arrays(6);
  data.cell_arrays = make_arrays(1);
  write_wedges(folder / "a.vtu", data);
  const WedgeData back = read_wedges(folder / "a.vtu");
  EXPECT_EQ(back.points, data.points);
  EXPECT_EQ(back.wedges, data.wedges);
  expect_equal(back.point_arrays, data.point_arrays);
  expect_equal(back.cell_arrays, data.cell_arrays);
  EXPECT_THROW(read_tets(folder / "a.vtu"), InputError);
}

TEST(Files, SayTheirSpace) {
  const TemporaryFolder folder;
  const SurfaceData data = make_surface();
  for (const std::string name : {"a.vtp", "a.stl", "a.ply"}) write_surface(folder / name, data);
  TetData tets;
  tets.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tets.mesh.tets = {{0, 1, 2, 3}};
  write_tets(folder / "a.vtu", tets);
  for (const std::string name : {"a.vtp", "a.vtu"})
    EXPECT_THAT(read_text(folder / name), HasSubstr("Name=\"SPACE\"")) << name;
  EXPECT_THAT(read_text(folder / "a.stl").substr(0, 80), HasSubstr("SPACE=LPS"));
  EXPECT_THAT(read_text(folder / "a.ply").substr(0, 80), HasSubstr("comment SPACE=LPS"));
}

TEST(Files, SameInputGivesSameBytesAndLeavesNothingElse) {
  const TemporaryFolder folder;
  const SurfaceData data = make_surface();
  for (const std::string extension : {".vtp", ".stl", ".ply"}) {
    write_surface(folder / ("a" + extension), data);
    write_surface(folder / ("b" + extension), data);
    EXPECT_EQ(read_text(folder / ("a" + extension)), read_text(folder / ("b" + extension)));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 6);
}

TEST(Files, EmptyMeshesAreWrittenButRefusedAsInput) {
  const TemporaryFolder folder;
  for (const std::string name : {"a.vtp", "a.stl", "a.ply"}) {
    write_surface(folder / name, {});
    expect_refused(
        folder / name, [](const fs::path& p) { return read_surface(p); }, "no triangles");
  }
}

TEST(Files, FolderThatCannotBeMadeIsAnIoError) {
  const TemporaryFolder folder;
  write_text_atomically(folder / "file", "in the way");
  EXPECT_THROW(write_surface((folder / "file") / "a.vtp", make_surface()), IoError);
}

std::string ascii_vtp(const std::string& counts, const std::string& points,
                      const std::string& polys, const std::string& field = {}) {
  return "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
         "header_type=\"UInt32\"><PolyData>" +
         field + "<Piece " + counts +
         "><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">" +
         points + "</DataArray></Points>" + polys + "</Piece></PolyData></VTKFile>\n";
}

std::string ascii_polys(const std::string& connectivity, const std::string& offsets) {
  return "<Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">" + connectivity +
         "</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">" + offsets +
         "</DataArray></Polys>";
}

TEST(Vtp, PolygonsAreCutIntoTrianglesAndTaggedRasIsConverted) {
  const TemporaryFolder folder;
  const std::string ras =
      "<FieldData><DataArray type=\"String\" Name=\"SPACE\" NumberOfTuples=\"1\" "
      "format=\"ascii\">82 65 83 0</DataArray></FieldData>";
  write_text_atomically(folder / "a.vtp",
                        ascii_vtp("NumberOfPoints=\"4\" NumberOfPolys=\"1\"",
                                  "0 0 0 1 0 0 1 1 0 0 1 0", ascii_polys("0 1 2 3", "4"), ras));
  const TriangleMesh mesh = read_surface(folder / "a.vtp").mesh;
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_DOUBLE_EQ(surface_area(mesh), 1.0);
  EXPECT_EQ(mesh.vertices[2], (Vec3{-1, -1, 0}));
}

TEST(Vtp, BadFilesAreRefusedByName) {
  const TemporaryFolder folder;
  const std::string three = "NumberOfPoints=\"3\" NumberOfPolys=\"1\"";
  expect_surface_refused(folder / "a.vtp", "a text", "not a VTK XML");
  expect_surface_refused(folder / "a.vtp", "<VTKFile type=\"ImageData\"></VTKFile>",
                         "another kind");
  expect_surface_refused(folder / "a.vtp",
                         ascii_vtp(three, "0 0 0 1 0 0 nan 1 0", ascii_polys("0 1 2", "3")),
                         "not a number");
  expect_surface_refused(folder / "a.vtp",
                         ascii_vtp(three, "0 0 0 1 0 0 0 1 0", ascii_polys("0 1 7", "3")), "a.vtp");
  expect_surface_refused(folder / "a.vtp",
                         ascii_vtp("NumberOfPoints=\"999999999999\" NumberOfPolys=\"1\"", "0 0 0",
                                   ascii_polys("0 0 0", "3")),
                         "absurd");
  write_surface(folder / "b.vtp", make_surface());
  const std::string whole = read_text(folder / "b.vtp");
  for (const double part : {0.3, 0.6, 0.9})
    expect_surface_refused(folder / "c.vtp",
                           whole.substr(0, std::size_t(part * double(whole.size()))), "c.vtp");
}

TEST(Vtp, ManySurfacesComeInTheirOrderAndABadOneIsNamed) {
  const TemporaryFolder folder;
  std::vector<fs::path> paths;
  for (const char* name : {"c.vtp", "a.vtp", "b.vtp"}) {
    SurfaceData data = make_surface();
    for (Vec3& p : data.mesh.vertices) p.x += double(paths.size());
    write_surface(folder / name, data);
    paths.push_back(folder / name);
  }
  const std::vector<SurfaceData> all = read_vtp_surfaces(paths);
  ASSERT_EQ(all.size(), paths.size());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const SurfaceData one = read_surface(paths[i]);
    expect_equal(all[i].mesh, one.mesh);
    expect_equal(all[i].point_arrays, one.point_arrays);
  }
  EXPECT_TRUE(read_vtp_surfaces({}).empty());
  const auto read_all = [&](const fs::path&) { return read_vtp_surfaces(paths); };
  const std::string whole = read_text(folder / "a.vtp");
  write_text_atomically(folder / "a.vtp", whole.substr(0, whole.size() / 2));
  expect_refused(folder / "a.vtp", read_all, "a.vtp");
  write_text_atomically(folder / "a.vtp", "a text");
  expect_refused(folder / "a.vtp", read_all, "not a VTK XML");
}

TEST(Vtp, LinesAreNoSurfaceAndSurfacesHoldNoLines) {
  const TemporaryFolder folder;
  write_surface(folder / "surface.vtp", make_surface());
  expect_refused(
      folder / "surface.vtp", [](const fs::path& p) { return read_polylines(p); }, "no lines");
  PolylineData lines;
  lines.points = {{0, 0, 0}, {1, 0, 0}};
  lines.lines = {{0, 1}};
  write_polylines(folder / "lines.vtp", lines);
  expect_refused(
      folder / "lines.vtp", [](const fs::path& p) { return read_surface(p); }, "no triangles");
}

TEST(Arrays, MissingOneIsNamed) {
  const std::vector<DataArray> arrays = make_arrays(3);
  EXPECT_EQ(find_array(arrays, "GroupIds").type, ArrayType::int32);
  try {
    find_array(arrays, "Abscissas");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("Abscissas"));
  }
}

TEST(Arrays, WrongLengthIsOurMistake) {
  const TemporaryFolder folder;
  SurfaceData data = make_surface();
  data.point_arrays[0].values.pop_back();
  EXPECT_THROW(write_surface(folder / "a.vtp", data), InternalError);
  EXPECT_FALSE(fs::exists(folder / "a.vtp"));
}

TEST(Collection, ListsEveryStepAndEscapesNames) {
  const TemporaryFolder folder;
  write_collection(folder / "a.pvd",
                   {{0.0, 0, "frames/balloon_000000.vtp"}, {0.025, 1, "frames/a&b.vtp"}});
  const std::string xml = read_text(folder / "a.pvd");
  EXPECT_THAT(xml, HasSubstr("<VTKFile type=\"Collection\""));
  EXPECT_THAT(xml, HasSubstr("timestep=\"0\" part=\"0\" file=\"frames/balloon_000000.vtp\""));
  EXPECT_THAT(xml, HasSubstr("timestep=\"0.025\" part=\"1\" file=\"frames/a&amp;b.vtp\""));
}

TEST(RealData, ClosedCoronarySurfaceIsReadWatertight) {
  const char* data = std::getenv("ANGIO_DATA");
  if (!data) GTEST_SKIP() << "ANGIO_DATA is not set";
  const TriangleMesh mesh = read_surface(fs::path(data) / "coronary-lumen-xra/lumen.stl").mesh;
  EXPECT_EQ(mesh.triangles.size(), 14336u);  // counted in the file: data/README.md
  EXPECT_TRUE(surface_topology(mesh).is_closed());
}

TEST(RealData, VmtkCenterlineKeepsItsArrays) {
  const char* data = std::getenv("ANGIO_DATA");
  if (!data) GTEST_SKIP() << "ANGIO_DATA is not set";
  const PolylineData lines = read_polylines(fs::path(data) / "mra-aorta-vmtk/aorta-centerline.vtp");
  const DataArray& radius = find_array(lines.point_arrays, "MaximumInscribedSphereRadius");
  EXPECT_EQ(radius.values.size(), lines.points.size());
}

}  // namespace
}  // namespace angio::formats

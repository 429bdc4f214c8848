#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/files.hpp"
#include "testing/viewer/shapes.hpp"
#include "tests/formats/expectations.hpp"

namespace angio::formats {
namespace {
namespace fs = std::filesystem;
using viewer::test::make_cube;
using viewer::test::TemporaryFolder;

constexpr const char* kCubePoints =
    "POINTS 8 float\n0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1\n";

TEST(MeshFiles, AVolumeMeshIsReadAsItsBoundary) {
  const TemporaryFolder folder;
  TetData cube;
  cube.mesh.vertices = make_cube().vertices;
  const auto corner = [&](double x, double y, double z) {
    for (std::size_t v = 0; v < cube.mesh.vertices.size(); ++v)
      if (cube.mesh.vertices[v] == Vec3{x, y, z}) return int(v);
    return -1;
  };
  const int a = corner(0, 0, 0), b = corner(1, 1, 0), c = corner(1, 0, 1), d = corner(0, 1, 1);
  cube.mesh.tets = {{a, b, c, d},
                    {a, corner(1, 0, 0), b, c},
                    {a, b, corner(0, 1, 0), d},
                    {a, c, d, corner(0, 0, 1)},
                    {b, d, c, corner(1, 1, 1)}};
  write_tets(folder / "cube.vtu", cube);
  const TriangleMesh boundary = read_surface(folder / "cube.vtu").mesh;
  EXPECT_EQ(boundary.triangles.size(), 12u);
  EXPECT_TRUE(surface_topology(boundary).is_closed());
  EXPECT_DOUBLE_EQ(std::abs(enclosed_volume(boundary)), 1.0);
}

constexpr const char* kCubeOfMedit =
    "MeshVersionFormatted 1\nDimension 3\nVertices 9\n0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n"
    "0 0 1 1\n1 0 1 1\n1 1 1 1\n0 1 1 1\n0.5 0.5 2 1\n";

void expect_solid(const fs::path& file, std::size_t triangles, double volume) {
  const TriangleMesh mesh = read_surface(file).mesh;
  EXPECT_EQ(mesh.triangles.size(), triangles);
  EXPECT_TRUE(surface_topology(mesh).is_closed());
  EXPECT_NEAR(enclosed_volume(mesh), volume, 1e-12);  // outwards, so positive
}

TEST(MeshFiles, SolidCellsOfEveryShapeAreReadAsTheirBoundaryFromOutside) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& cells, std::size_t triangles, double volume) {
    write_text_atomically(folder / "cube.mesh", kCubeOfMedit + cells + "End\n");
    expect_solid(folder / "cube.mesh", triangles, volume);
  };
  read("Hexahedra 1\n1 2 3 4 5 6 7 8 0\n", 12, 1.0);
  read("Hexahedra 1\n1 2 3 4 5 6 7 8 0\nPyramids 1\n5 6 7 8 9 0\n", 14, 1.0 + 1.0 / 3.0);
  read("Prisms 2\n1 2 3 5 6 7 0\n1 3 4 5 7 8 0\n", 12, 1.0);
  // What is flat inside a solid, or a line, is no part of its surface.
  read("Ridges 1\n1\nTetrahedra 1\n1 2 4 5 0\nTriangles 1\n2 3 6 7\n", 4, 1.0 / 6.0);
}

TEST(MeshFiles, AMeshOfGmshIsReadAsItsBoundaryWithoutTheNodesInBetween) {
  const TemporaryFolder folder;
  // A tetrahedron of second order, a line and a point; the section's end is missing at last.
  write_text_atomically(
      folder / "tet.msh",
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"Wall\"\n$EndPhysicalNames\n"
      "$Nodes\n10\n5 0 0 0\n6 2 0 0\n7 0 2 0\n8 0 0 2\n21 1 0 0\n22 1 1 0\n23 0 1 0\n24 0 0 1\n"
      "25 0 1 1\n26 1 0 1\n$EndNodes\n$Elements\n3\n1 15 2 0 1 5\n2 1 2 0 1 5 6\n"
      "3 11 2 0 1 5 6 7 8 21 22 23 24 25 26\n");
  expect_solid(folder / "tet.msh", 4, 8.0 / 6.0);
  const auto refused = [&](const std::string& text, const char* why) {
    write_text_atomically(folder / "wrong.msh", text);
    try {
      read_surface(folder / "wrong.msh");
      ADD_FAILURE() << why;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(why));
    }
  };
  // A cell that is there once for each of its groups counts once.
  const std::string two =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
      "4 0 0 1\n5 1 1 1\n$EndNodes\n$Elements\n";
  write_text_atomically(folder / "twice.msh", two +
                                                  "3\n1 4 2 1 1 1 2 3 4\n2 4 2 2 1 1 2 3 4\n"
                                                  "3 4 2 1 1 2 3 4 5\n$EndElements\n");
  expect_solid(folder / "twice.msh", 6, 0.5);
  refused(two + "1\n1 4 2 1 1 1 2 3 9\n$EndElements\n", "not there");
  refused(two + "-1\n$EndElements\n", "fewer than none");
  refused("$MeshFormat\n4 0 8\n$EndMeshFormat\n", "version 4.0");
  refused("$Nodes\n1\n1 0 0 0\n$EndNodes\n", "does not begin with $MeshFormat");
  const std::string head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0 0 0\n";
  refused(head + "1 1 0 0\n$EndNodes\n", "two nodes");
  refused(head + "2 1 0 0\n$EndNodes\n", "no elements");
  refused(head + "2 1 0 0\n$EndNodes\n$Elements\n1\n1 2 2 0 1 1 2 3\n$EndElements\n", "not there");
  refused(head + "2 1 0 0\n$EndNodes\n$Elements\n1\n1 77 2 0 1 1 2\n$EndElements\n", "type 77");
}

TEST(MeshFiles, OffIsReadWithItsColoursAndPolygons) {
  const TemporaryFolder folder;
  const std::string cube =
      "COFF 8 6 0  # in cm\n0 0 0 255 0 0 1\n1 0 0 0 0 0 1\n1 1 0 0 0 0 1\n0 1 0 0 0 0 1\n"
      "0 0 1 0 0 0 1\n\n1 0 1 0 0 0 1\n1 1 1 0 0 0 1\n0 1 1 0 0 0 1\n"
      "4 0 3 2 1\n4 4 5 6 7 0.1 0.2 0.3\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
  write_text_atomically(folder / "cube.off", cube);
  expect_solid(folder / "cube.off", 12, 1.0);
  for (const auto& [from, to] : {std::pair{"COFF", "4OFF"},
                                 {"COFF", "OFF BINARY"},
                                 {"4 3 0 4 7", "4 3 0 4 8"},
                                 {"8 6 0", "8 7 0"},
                                 {"8 6 0", "-8 6 0"},
                                 {"1 0 0 0 0", "1 x 0 0 0"}}) {
    std::string wrong = cube;
    wrong.replace(wrong.find(from), std::string(from).size(), to);
    write_text_atomically(folder / "wrong.off", wrong);
    EXPECT_THROW(read_surface(folder / "wrong.off"), InputError) << to;
  }
}

TEST(MeshFiles, AGridOfTheLegacyFormatIsReadAsItsFaces) {
  const TemporaryFolder folder;
  const std::string head = "# vtk DataFile Version 3.0\nmade by hand\nASCII\nDATASET ";
  const std::string cube = head + "UNSTRUCTURED_GRID\n" + kCubePoints +
                           "CELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n12\n";
  write_text_atomically(folder / "cube.vtk", cube);
  const TriangleMesh boundary = read_surface(folder / "cube.vtk").mesh;
  EXPECT_TRUE(surface_topology(boundary).is_closed());
  EXPECT_DOUBLE_EQ(std::abs(enclosed_volume(boundary)), 1.0);
  // A tube of quadrilaterals whose seam is there twice.
  write_text_atomically(folder / "tube.vtk",
                        head +
                            "STRUCTURED_GRID\nDIMENSIONS 5 2 1\nPOINTS 10 float\n1 0 0 0 1 0 -1 0 "
                            "0 0 -1 0 1 0 0\n1 0 3 0 1 3 -1 0 3 0 -1 3 1 0 3\n");
  const TriangleMesh tube = read_surface(folder / "tube.vtk").mesh;
  EXPECT_EQ(tube.vertices.size(), 8u);
  EXPECT_EQ(tube.triangles.size(), 8u);
  for (std::size_t length = cube.find("POINTS"); length < cube.find("CELL_TYPES") - 1;
       length += 3) {
    write_text_atomically(folder / "cut.vtk", cube.substr(0, length));
    EXPECT_THROW(read_surface(folder / "cut.vtk"), InputError) << length;
  }
  for (const auto& [from, to] : {std::pair{"4 5 6 7", "4 5 6 9"},
                                 {"CELL_TYPES 1\n12", "CELL_TYPES 2\n12 12"},
                                 {"0 1 2 3", "-1 1 2 3"}}) {
    std::string wrong = cube;
    wrong.replace(wrong.find(from), std::string(from).size(), to);
    write_text_atomically(folder / "wrong.vtk", wrong);
    EXPECT_THROW(read_surface(folder / "wrong.vtk"), InputError) << to;
  }
  write_text_atomically(folder / "wrong.vtk",
                        head + "STRUCTURED_GRID\nDIMENSIONS 5 9 1\n" + std::string(kCubePoints));
  EXPECT_THROW(read_surface(folder / "wrong.vtk"), InputError);
}

TEST(Stl, MergesEqualPointsIntoAClosedSurface) {
  const TemporaryFolder folder;
  SurfaceData data;
  data.mesh = make_cube();
  write_surface(folder / "a.stl", data);
  EXPECT_EQ(fs::file_size(folder / "a.stl"), 84u + 50u * 12u);
  const TriangleMesh back = read_surface(folder / "a.stl").mesh;
  EXPECT_EQ(back.vertices.size(), 8u);
  EXPECT_TRUE(surface_topology(back).is_closed());
  EXPECT_DOUBLE_EQ(enclosed_volume(back), 1.0);
}

TEST(Stl, BinaryWhoseHeaderBeginsWithSolidIsRead) {
  const TemporaryFolder folder;
  SurfaceData data;
  data.mesh = make_cube();
  write_surface(folder / "a.stl", data);
  std::string bytes = read_text(folder / "a.stl");
  bytes.replace(0, 12, "solid facet ");
  write_text_atomically(folder / "b.stl", bytes);
  EXPECT_EQ(read_surface(folder / "b.stl").mesh.triangles.size(), 12u);
}

std::string ascii_facet(const std::string& corners) {
  return "facet normal 0 0 1\n outer loop\n" + corners + " endloop\nendfacet\n";
}

TEST(Stl, AsciiIsReadWithAnyNumberFormatAndRasIsConverted) {
  const TemporaryFolder folder;
  write_text_atomically(folder / "a.stl",
                        "solid part SPACE=RAS\r\n" +
                            ascii_facet("vertex 1.5e+00 2 3\n vertex +2 2 3\n vertex 1.5 4. 3\n") +
                            "endsolid\n");
  const TriangleMesh mesh = read_surface(folder / "a.stl").mesh;
  const std::vector<Vec3> expected{{-1.5, -2, 3}, {-2, -2, 3}, {-1.5, -4, 3}};
  EXPECT_EQ(mesh.vertices, expected);
}

TEST(Stl, PositiveAndNegativeZeroAreOnePoint) {
  const TemporaryFolder folder;
  write_text_atomically(folder / "a.stl",
                        "solid\n" + ascii_facet("vertex 0 0 0 vertex 1 0 0 vertex 0 1 0\n") +
                            ascii_facet("vertex -0 0 0 vertex 0 1 0 vertex -1 0 0\n") +
                            "endsolid\n");
  EXPECT_EQ(read_surface(folder / "a.stl").mesh.vertices.size(), 4u);
}

TEST(Stl, DegenerateTrianglesAreDropped) {
  const TemporaryFolder folder;
  write_text_atomically(folder / "a.stl",
                        "solid\n" + ascii_facet("vertex 0 0 0 vertex 1 0 0 vertex 0 1 0\n") +
                            ascii_facet("vertex 1 0 0 vertex 1 0 0 vertex 0 1 0\n") + "endsolid\n");
  EXPECT_EQ(read_surface(folder / "a.stl").mesh.triangles.size(), 1u);
}

TEST(Stl, BadFilesAreRefusedByName) {
  const TemporaryFolder folder;
  expect_refused(
      folder / "none.stl", [](const fs::path& p) { return read_surface(p); }, "no such file");
  expect_surface_refused(folder / "a.stl", "", "is empty");
  expect_surface_refused(folder / "a.stl", "This is a letter, not a mesh.\n", "not an STL");
  expect_surface_refused(folder / "a.stl", "solid nothing\nendsolid\n", "not an STL");
  expect_surface_refused(
      folder / "a.stl",
      "solid\n" + ascii_facet("vertex nan 0 0 vertex 1 0 0 vertex 0 1 0\n") + "endsolid\n",
      "not a number");
  expect_surface_refused(folder / "a.stl",
                         "solid\n" + ascii_facet("vertex 0 zero 0 vertex 1 0 0 vertex 0 1 0\n"),
                         "facet 1");
  expect_surface_refused(folder / "a.stl", "solid\n" + ascii_facet("vertex 0 0 0 vertex 1 0 0\n"),
                         "2 corners");
  SurfaceData cube;
  cube.mesh = make_cube();
  write_surface(folder / "b.stl", cube);
  const std::string whole = read_text(folder / "b.stl");
  expect_surface_refused(folder / "c.stl", whole.substr(0, 300), "cut short");
  std::string absurd = whole;
  absurd.replace(80, 4, "\xff\xff\xff\xff");
  expect_surface_refused(folder / "d.stl", absurd, "cut short");
  std::string picture = "\x89PNG";  // zeros in its head, and numbers that are none behind it
  picture.resize(80, '\0');
  picture.resize(800, '\xfb');
  expect_surface_refused(folder / "e.stl", picture, "is not an STL surface");
  // As programs write it that fill the whole header with their name.
  std::string named = whole.substr(0, 300);
  named.replace(0, 80, std::string(80, 'x'));
  expect_surface_refused(folder / "g.stl", named,
                         "12 triangles, so 84 + 50 x 12 = 684 bytes; it has 300");
  expect_surface_refused(folder / "h.stl", std::string(400, '7'), "not an STL");
  write_text_atomically(folder / "e.stl", whole + "what another program has written behind it");
  EXPECT_EQ(read_surface(folder / "e.stl").mesh.triangles.size(), cube.mesh.triangles.size());
  std::string broken = whole + "and more";
  broken.replace(100, 4, "\xff\xff\xff\x7f");  // no number
  expect_surface_refused(folder / "f.stl", broken, "STL");
}

TEST(Ply, ComesBackExactly) {
  const TemporaryFolder folder;
  SurfaceData data;
  data.mesh = make_cube({1.0 / 3.0, 0.1, 7e-9});
  write_surface(folder / "a.ply", data);
  expect_equal(read_surface(folder / "a.ply").mesh, data.mesh);
}

TEST(Ply, AsciiPolygonsWithOtherPropertiesAreCutIntoTriangles) {
  const TemporaryFolder folder;
  write_text_atomically(folder / "a.ply",
                        "ply\nformat ascii 1.0\ncomment SPACE=RAS\nelement vertex 4\n"
                        "property float x\nproperty float y\nproperty float z\n"
                        "property uchar red\nelement face 1\n"
                        "property list uchar int vertex_index\nproperty float quality\n"
                        "end_header\n0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n4 0 1 2 3 0.5\n");
  const TriangleMesh mesh = read_surface(folder / "a.ply").mesh;
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_DOUBLE_EQ(surface_area(mesh), 1.0);
  EXPECT_EQ(mesh.vertices[2], (Vec3{-1, -1, 0}));
}

TEST(Ply, BadFilesAreRefusedByName) {
  const TemporaryFolder folder;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  expect_surface_refused(folder / "a.ply", "hello", "PLY");
  expect_surface_refused(folder / "a.ply", "ply\nformat ascii 1.0\n", "no end");
  expect_surface_refused(folder / "a.ply", head + "0 0 0\n1 0 0\n", "ends too early");
  expect_surface_refused(folder / "a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n",
                         "does not have");
  expect_surface_refused(folder / "a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "not there");
  expect_surface_refused(folder / "a.ply",
                         "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
                         "property float x\nend_header\n",
                         "cut short");
  expect_surface_refused(folder / "a.ply",
                         "ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n"
                         "property float x\nend_header\n",
                         "no count");
}

TEST(Obj, FacesOfAnyFormBecomeTriangles) {
  const TemporaryFolder folder;
  write_text_atomically(folder / "a.obj",
                        "# SPACE=RAS\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\n"
                        "f 1/1/1 2//1 3/2 4\nf -4 -3 -1\n");
  const TriangleMesh mesh = read_surface(folder / "a.obj").mesh;
  EXPECT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.triangles[2], (Triangle{0, 1, 3}));
  EXPECT_EQ(mesh.vertices[1], (Vec3{-1, 0, 0}));
}

TEST(Obj, BadFilesAreRefusedByName) {
  const TemporaryFolder folder;
  const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
  expect_surface_refused(folder / "a.obj", points + "f 1 2 9\n", "line 4");
  expect_surface_refused(folder / "a.obj", points + "f 1 2", "fewer than three");
  expect_surface_refused(folder / "a.obj", points + "f 1 2\n", "no triangles");
  expect_surface_refused(folder / "a.obj", points + "f a b c\n", "not a list");
  expect_surface_refused(folder / "a.obj", "v 0 0\n", "three numbers");
  expect_surface_refused(folder / "a.obj", "just words\n", "no triangles");
}

}  // namespace
}  // namespace angio::formats

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/files.hpp"
#include "formats/gltf.hpp"
#include "formats/text.hpp"
#include "testing/shapes.hpp"
#include "testing/viewer/shapes.hpp"

// A file that was cut short is refused, wherever it was cut.
namespace angio::formats {
namespace {

using testing::HasSubstr;
using viewer::test::TemporaryFolder;

TriangleMesh vessel() { return tests::make_tube(1.5, 12.0, 25, 16); }
TriangleMesh ball() { return tests::make_sphere({10, -20, 30}, 4.0, 3); }

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6f", value);
  return text;
}

std::string point_text(const Vec3& p) {
  return number(p.x) + " " + number(p.y) + " " + number(p.z);
}

std::string ascii_stl(const TriangleMesh& mesh) {
  std::string text = "solid vessel\n";
  for (const Triangle& t : mesh.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int v : t) text += "vertex " + point_text(mesh.vertices[std::size_t(v)]) + "\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid vessel\n";
}

std::string obj(const TriangleMesh& mesh, bool last_break) {
  std::string text = "# made by hand\n";
  for (const Vec3& p : mesh.vertices) text += "v " + point_text(p) + "\n";
  for (const Triangle& t : mesh.triangles)
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
            std::to_string(t[2] + 1) + "\n";
  if (!last_break) text.pop_back();
  return text;
}

std::string ascii_ply(const TriangleMesh& mesh) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " +
                     std::to_string(mesh.vertices.size()) +
                     "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                     std::to_string(mesh.triangles.size()) +
                     "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& p : mesh.vertices) text += point_text(p) + "\n";
  for (const Triangle& t : mesh.triangles)
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) +
            "\n";
  return text;
}

std::string ascii_vtp(const TriangleMesh& mesh) {
  std::string points, corners, offsets;
  for (const Vec3& p : mesh.vertices) points += point_text(p) + "\n";
  int offset = 0;
  for (const Triangle& t : mesh.triangles) {
    for (const int v : t) corners += std::to_string(v) + " ";
    offsets += std::to_string(offset += 3) + " ";
  }
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
         "byte_order=\"LittleEndian\" header_type=\"UInt32\"><PolyData><Piece NumberOfPoints=\"" +
         std::to_string(mesh.vertices.size()) + "\" NumberOfPolys=\"" +
         std::to_string(mesh.triangles.size()) +
         "\"><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">\n" +
         points +
         "</DataArray></Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\" "
         "format=\"ascii\">" +
         corners + "</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">" +
         offsets + "</DataArray></Polys></Piece></PolyData></VTKFile>\n";
}

template <class Number>
std::string little_endian(Number number) {
  return std::string(reinterpret_cast<const char*>(&number), sizeof number);
}

template <class Number>
std::string big_endian(Number number) {
  std::string bytes = little_endian(number);
  std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// VTK's legacy format; from version 5 on, cells are where each begins, and points.
std::string legacy_vtk(const TriangleMesh& mesh, bool is_text, bool is_version_5) {
  const auto value = [&](auto number) {
    return is_text ? std::to_string(number) + " " : big_endian(number);
  };
  const auto count = std::to_string(mesh.triangles.size());
  std::string points, cells, offsets = value(std::int64_t(0)), corners;
  std::int64_t end = 0;
  for (const Vec3& p : mesh.vertices) points += value(p.x) + value(p.y) + value(p.z);
  for (const Triangle& t : mesh.triangles) {
    cells += value(3) + value(t[0]) + value(t[1]) + value(t[2]);
    for (const int v : t) corners += value(std::int64_t(v));
    offsets += value(end += 3);
  }
  const std::string head = std::string("# vtk DataFile Version ") + (is_version_5 ? "5.1" : "3.0") +
                           "\nmade by hand\n" + (is_text ? "ASCII" : "BINARY") +
                           "\nDATASET POLYDATA\nPOINTS " + std::to_string(mesh.vertices.size()) +
                           " double\n" + points + "\nPOLYGONS ";
  return is_version_5
             ? head + std::to_string(mesh.triangles.size() + 1) + " " +
                   std::to_string(3 * mesh.triangles.size()) + "\nOFFSETS vtktypeint64\n" +
                   offsets + "\nCONNECTIVITY vtktypeint64\n" + corners + "\n"
             : head + count + " " + std::to_string(4 * mesh.triangles.size()) + "\n" + cells + "\n";
}

std::string off(const TriangleMesh& mesh) {
  std::string text = "OFF\n# made by hand\n" + std::to_string(mesh.vertices.size()) + " " +
                     std::to_string(mesh.triangles.size()) + " 0\n";
  for (const Vec3& p : mesh.vertices) text += point_text(p) + "\n";
  for (const Triangle& t : mesh.triangles)
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) +
            "\n";
  return text;
}

std::string medit(const TriangleMesh& mesh) {
  std::string text = "MeshVersionFormatted 2\nDimension\n3\nVertices\n" +
                     std::to_string(mesh.vertices.size()) + "\n";
  for (const Vec3& p : mesh.vertices) text += point_text(p) + " 0\n";
  text += "Edges 1\n1 2 7\nTriangles\n" + std::to_string(mesh.triangles.size()) + "\n";
  for (const Triangle& t : mesh.triangles)
    text += std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
            std::to_string(t[2] + 1) + " 4\n";
  return text + "End\n";
}

/// Nodes and elements are numbered from 11 on.
std::string gmsh(const TriangleMesh& mesh, bool is_text, bool is_version_4) {
  const auto value = [&](auto number) {
    return is_text ? std::to_string(number) + " " : little_endian(number);
  };
  const auto size = [&](std::size_t number) { return value(std::uint64_t(number)); };
  const auto name = [&](std::size_t k) {
    return is_version_4 ? size(k + 11) : value(std::int32_t(k + 11));
  };
  const auto pair = [&](const char* section, std::size_t count, const std::string& body) {
    return std::string("$") + section + "\n" +
           (is_version_4 ? size(1) + size(count) + size(11) + size(count + 10)
                         : std::to_string(count) + "\n") +
           body + "\n$End" + section + "\n";
  };
  const std::size_t points = mesh.vertices.size(), triangles = mesh.triangles.size();
  std::string nodes, elements;
  if (is_version_4) {
    nodes = value(2) + value(1) + value(0) + size(points);
    for (std::size_t i = 0; i < points; ++i) nodes += name(i);
    elements = value(2) + value(1) + value(2) + size(triangles);
  } else if (!is_text) {
    elements = value(2) + value(int(triangles)) + value(2);
  }
  for (std::size_t i = 0; i < points; ++i)
    nodes += (is_version_4 ? "" : name(i)) + value(mesh.vertices[i].x) + value(mesh.vertices[i].y) +
             value(mesh.vertices[i].z);
  for (std::size_t i = 0; i < triangles; ++i) {
    elements += name(i);
    if (!is_version_4) elements += (is_text ? value(2) + value(2) : "") + value(3) + value(1);
    for (const int v : mesh.triangles[i]) elements += name(std::size_t(v));
  }
  return std::string("$MeshFormat\n") + (is_version_4 ? "4.1" : "2.2") + (is_text ? " 0" : " 1") +
         " 8\n" + (is_text ? "" : little_endian(std::int32_t(1)) + "\n") + "$EndMeshFormat\n" +
         pair("Nodes", points, nodes) + pair("Elements", triangles, elements);
}

std::string written(const TemporaryFolder& folder, const std::string& extension,
                    const TriangleMesh& mesh) {
  write_surface(folder / ("whole" + extension), {mesh, {}, {}});
  return read_text(folder / ("whole" + extension));
}

/// Triangles read from a text, or nothing if it is refused.
std::optional<std::size_t> triangles_read(const TemporaryFolder& folder,
                                          const std::string& extension, const std::string& bytes) {
  std::ofstream(folder / ("cut" + extension), std::ios::binary) << bytes;
  try {
    return read_surface(folder / ("cut" + extension)).mesh.triangles.size();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::Not(HasSubstr("\n")));
    return std::nullopt;
  }
}

/// Places to cut at: spread over the file, and every byte of its ends.
std::vector<std::size_t> cuts(std::size_t size) {
  std::vector<std::size_t> at;
  for (std::size_t i = 1; i < 40 && i < size; ++i) at.insert(at.end(), {i, size - i});
  std::mt19937_64 random(11);
  for (int i = 0; i < 60; ++i) at.push_back(1 + random() % (size - 1));
  return at;
}

struct Whole {
  std::string name, extension, bytes;
  std::size_t triangle_count;
};

std::vector<Whole> whole_files(const TemporaryFolder& folder) {
  std::vector<Whole> files;
  for (const bool open : {true, false}) {
    const TriangleMesh mesh = open ? vessel() : ball();
    const std::string kind = open ? "open " : "closed ";
    const auto add = [&](const char* name, const char* extension, const std::string& bytes) {
      files.push_back({kind + name, extension, bytes, mesh.triangles.size()});
    };
    add("binary STL", ".stl", written(folder, ".stl", mesh));
    add("ASCII STL", ".stl", ascii_stl(mesh));
    add("binary PLY", ".ply", written(folder, ".ply", mesh));
    add("ASCII PLY", ".ply", ascii_ply(mesh));
    add("appended VTP", ".vtp", written(folder, ".vtp", mesh));
    add("ASCII VTP", ".vtp", ascii_vtp(mesh));
    write_gltf(folder / "whole.glb", {{{"vessel", mesh, {1, 0, 0}, 1.0, {}}}, {}});
    add("glTF", ".glb", read_text(folder / "whole.glb"));
    add("OFF", ".off", off(mesh));
    add("Medit", ".mesh", medit(mesh));
    for (const bool is_text : {true, false})
      for (const bool is_version_4 : {true, false})
        add(is_text ? "ASCII Gmsh" : "binary Gmsh", ".msh", gmsh(mesh, is_text, is_version_4));
    for (const bool is_text : {true, false})
      for (const bool is_version_5 : {true, false})
        add(is_text ? "ASCII VTK" : "binary VTK", ".vtk", legacy_vtk(mesh, is_text, is_version_5));
  }
  return files;
}

TEST(CutFiles, AreRefusedWhereverTheyEndBeforeTheLastTriangle) {
  const TemporaryFolder folder;
  for (const Whole& file : whole_files(folder)) {
    ASSERT_EQ(triangles_read(folder, file.extension, file.bytes), file.triangle_count) << file.name;
    for (const std::size_t size : cuts(file.bytes.size())) {
      const auto count = triangles_read(folder, file.extension, file.bytes.substr(0, size));
      // What is lost past the last triangle is a line break, the solid's name or a section's end.
      if (count) {
        const std::size_t behind = file.extension == ".msh" ? 14 : 8;
        EXPECT_EQ(*count, file.triangle_count) << file.name << " at " << size;
        EXPECT_LE(file.bytes.size() - size, behind) << file.name << " at " << size;
      }
    }
  }
}

TEST(CutFiles, LegacyVtkOfPointsThatAreNoNumbersIsRefused) {
  const TemporaryFolder folder;
  const std::string whole = legacy_vtk(ball(), true, false);
  for (const std::string type : {"string", "float0", "bit"}) {
    std::string changed = whole;
    changed.replace(changed.find(" double"), 7, " " + type);
    EXPECT_EQ(triangles_read(folder, ".vtk", changed), std::nullopt) << type;
  }
}

TEST(CutFiles, ObjFilesAreReadOnlyIfTheyEndWithAWholeFace) {
  const TemporaryFolder folder;
  for (const bool open : {true, false}) {
    const TriangleMesh mesh = open ? vessel() : ball();
    const std::string whole = obj(mesh, true);
    ASSERT_EQ(triangles_read(folder, ".obj", whole), mesh.triangles.size());
    int read_count = 0;
    for (const std::size_t size : cuts(whole.size())) {
      const std::string part = whole.substr(0, size);
      const auto count = triangles_read(folder, ".obj", part);
      if (!count || *count == mesh.triangles.size()) continue;
      // The format has neither count nor end: a cut behind a face, where every point is in use,
      // cannot be seen. No face may be a wrong one.
      ++read_count;
      const auto faces = std::size_t(std::count(part.begin(), part.end(), 'f'));
      const std::string line = part.substr(part.rfind('f'));
      const Triangle& last = mesh.triangles[faces - 1];
      EXPECT_EQ(line.substr(0, line.find('\n')), "f " + std::to_string(last[0] + 1) + " " +
                                                     std::to_string(last[1] + 1) + " " +
                                                     std::to_string(last[2] + 1))
          << size;
    }
    EXPECT_LT(read_count, 20);
  }
}

TEST(CutFiles, LoosePointsAtAnObjFilesEndShowACutUnlessFewAreBesideAWholeSurface) {
  const TemporaryFolder folder;
  const auto read = [&](TriangleMesh mesh, const std::vector<Vec3>& loose) {
    mesh.vertices.insert(mesh.vertices.end(), loose.begin(), loose.end());
    return triangles_read(folder, ".obj", obj(mesh, true));
  };
  const TriangleMesh closed = ball();
  const std::vector<Vec3> few{{90.0, 0.0, 0.0}, {91.0, 0.0, 0.0}};
  EXPECT_EQ(read(closed, few), closed.triangles.size());
  EXPECT_EQ(read(vessel(), few), std::nullopt);
  EXPECT_EQ(read(closed, closed.vertices), std::nullopt);  // a second one that lost its faces
}

TEST(CutFiles, ObjFilesWithoutALastLineBreakAreReadIfTheirLastFaceFits) {
  const TemporaryFolder folder;
  const std::string whole = obj(ball(), false);
  EXPECT_EQ(triangles_read(folder, ".obj", whole), ball().triangles.size());
  // A cut number names another point, which is there.
  const std::size_t last = whole.rfind(' ');
  ASSERT_GT(whole.size() - last, 2U);
  EXPECT_EQ(triangles_read(folder, ".obj", whole.substr(0, whole.size() - 1)), std::nullopt);
}

TEST(CutFiles, ObjCommentsThatPromiseMoreAreBelieved) {
  const TemporaryFolder folder;
  const std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 2 4 3\n";
  EXPECT_EQ(triangles_read(folder, ".obj", "# Vertices: 4\n# Faces: 3\n" + faces), 3U);
  EXPECT_EQ(triangles_read(folder, ".obj", "# Vertices: 4\n# Faces: 4\n" + faces), std::nullopt);
  EXPECT_EQ(triangles_read(folder, ".obj", faces + "# 4 faces\n"), std::nullopt);
}

TEST(Units, AreReadWhereAFileStatesThem) {
  const TemporaryFolder folder;
  const auto unit_of = [&](const char* extension, const std::string& bytes) {
    write_text_atomically(folder / (std::string("unit") + extension), bytes);
    return read_surface(folder / (std::string("unit") + extension)).unit;
  };
  const std::string facets = ascii_stl(vessel()).substr(12);
  EXPECT_EQ(unit_of(".stl", "solid vessel" + facets), std::nullopt);
  EXPECT_EQ(unit_of(".stl", "solid community of units" + facets), std::nullopt);
  EXPECT_EQ(unit_of(".stl", "solid vessel UNITS=CM" + facets), LengthUnit::cm);
  EXPECT_EQ(unit_of(".obj", "# File units = meters\n" + obj(vessel(), true)), LengthUnit::m);
  EXPECT_EQ(unit_of(".obj", "# Unit: inches\n" + obj(vessel(), true)), LengthUnit::inch);
  for (const char* extension : {".stl", ".ply", ".vtp"})
    EXPECT_EQ(unit_of(extension, written(folder, extension, vessel())), LengthUnit::mm);
}

}  // namespace
}  // namespace angio::formats

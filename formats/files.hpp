#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/data_array.hpp"
#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"
#include "core/units.hpp"

/// Surfaces, lines, tetrahedra and wedges in files, LPS [mm]. VTK's XML files carry the field-data
/// string array SPACE = LPS, STL and PLY headers SPACE=LPS. All writers are atomic and give the
/// same bytes for the same input. In .vtp, .vtu and .ply points are float64, so that a stage that
/// is run again from its files gets exactly the numbers that it got in memory; STL's format has
/// float32 only. Readers throw InputError naming the file: missing (66), empty, cut short, of
/// another kind, with a point that is not a number, or of an absurd size (65).
namespace angio::formats {

struct SurfaceData {
  TriangleMesh mesh;
  std::vector<DataArray> point_arrays;
  std::vector<DataArray> cell_arrays;
  std::optional<LengthUnit> unit = {};  ///< read: what the file says it is in; written: mm always
};

struct PolylineData {
  std::vector<Vec3> points;             ///< LPS [mm]
  std::vector<std::vector<int>> lines;  ///< point indices
  std::vector<DataArray> point_arrays;
  std::vector<DataArray> cell_arrays;
};

struct TetData {
  TetMesh mesh;
  std::vector<DataArray> point_arrays;
  std::vector<DataArray> cell_arrays;   ///< a tuple per tetrahedron, then one per boundary face
  std::vector<Triangle> boundary = {};  ///< faces that are cells of their own; may be empty
};

/// Triangular prisms: a triangle, then the one that its normal points to.
struct WedgeData {
  std::vector<Vec3> points;  ///< LPS [mm]
  std::vector<std::array<int, 6>> wedges;
  std::vector<DataArray> point_arrays;
  std::vector<DataArray> cell_arrays;
};

/// The array of that name. @throws InputError if it is missing
const DataArray& find_array(const std::vector<DataArray>& arrays, const std::string& name);

/// By the extension: .vtp with all arrays; .stl (binary), .ply and .obj without.
void write_surface(const std::filesystem::path& path, const SurfaceData& data);
void write_polylines(const std::filesystem::path& path, const PolylineData& data);  ///< .vtp
void write_tets(const std::filesystem::path& path, const TetData& data);            ///< .vtu
void write_wedges(const std::filesystem::path& path, const WedgeData& data);        ///< .vtu

/// Whether a file's extension is that of a surface or a mesh that read_surface reads.
bool is_surface_ending(std::string_view extension);
/// All of them, in words.
std::string surface_endings();

/// .vtp, .vtk (legacy), .vtu, .glb and .gltf (axes: write_gltf()), .stl (ASCII or binary), .ply,
/// .obj, .off, .msh (Gmsh), .mesh (Medit); of a grid or a mesh of solid cells its boundary.
/// Polygons are cut into triangles. Points of the same coordinates become one (an STL has three of
/// its own per triangle), and triangles that lose a corner by it are dropped; a file without such
/// points comes back as written, point by point. A header or SPACE array that says RAS is
/// converted; arrays of vectors are not.
SurfaceData read_surface(const std::filesystem::path& path);
PolylineData read_polylines(const std::filesystem::path& path);
/// Many .vtp files, in their order, at a small part of the price: one guarded process reads them.
std::vector<SurfaceData> read_vtp_surfaces(const std::vector<std::filesystem::path>& paths);
std::vector<PolylineData> read_polylines(const std::vector<std::filesystem::path>& paths);
TetData read_tets(const std::filesystem::path& path);
WedgeData read_wedges(const std::filesystem::path& path);

/// A data set of a ParaView collection (.pvd).
struct TimeStep {
  double time_s = 0.0;
  int part = 0;
  std::string file;  ///< relative to the .pvd
};
/// In the file's order.
std::vector<TimeStep> read_collection(const std::filesystem::path& path);
void write_collection(const std::filesystem::path& path, const std::vector<TimeStep>& steps);

}  // namespace angio::formats

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/data_array.hpp"
#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"

/// VTK XML and STL files in LPS [mm], with the field-data string array SPACE = LPS. All writers are
/// atomic and give the same bytes for the same input. Readers throw InputError naming the file.
namespace angio::viewer {

struct SurfaceData {
  TriangleMesh mesh;
  std::vector<DataArray> point_arrays;
  std::vector<DataArray> cell_arrays;
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
  std::vector<DataArray> cell_arrays;
};

/// The array of that name. @throws InputError if it is missing
const DataArray& find_array(const std::vector<DataArray>& arrays, const std::string& name);

void write_surface(const std::filesystem::path& path,
                   const SurfaceData& data);  ///< .vtp, .stl (binary), .ply
void write_polylines(const std::filesystem::path& path, const PolylineData& data);  ///< .vtp
void write_tets(const std::filesystem::path& path, const TetData& data);            ///< .vtu

/// .vtp .stl .ply .obj; header SPACE=RAS is converted, otherwise LPS. Equal points are merged.
SurfaceData read_surface(const std::filesystem::path& path);
PolylineData read_polylines(const std::filesystem::path& path);
TetData read_tets(const std::filesystem::path& path);

/// A ParaView collection.
struct TimeStep {
  double time_s = 0.0;
  int part = 0;
  std::string file;  ///< relative to the .pvd
};
void write_collection(const std::filesystem::path& path, const std::vector<TimeStep>& steps);

}  // namespace angio::viewer

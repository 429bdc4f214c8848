#pragma once

#include <filesystem>

#include "formats/detail/surface_formats.hpp"
#include "formats/files.hpp"

/// VTK's XML files. The writers fill the file that they are given: wrap them in write_atomically.
/// Points and arrays are exact (float64 points; zlib-compressed, appended raw).
class vtkFieldData;

namespace angio::formats::detail {

/// @param fields  more field data; null: none
void write_vtp(const std::filesystem::path& path, const SurfaceData& data,
               vtkFieldData* fields = nullptr);
void write_vtp(const std::filesystem::path& path, const PolylineData& data);
void write_vtu(const std::filesystem::path& path, const TetData& data);
void write_vtu(const std::filesystem::path& path, const WedgeData& data);

/// VTK's readers believe a damaged file, so that these are for a guarded child only: see
/// guarded_files.hpp. Polygons and strips are cut into triangles. A surface is .vtp or, by its
/// ending, .vtk, or the boundary of the mesh in a .vtu.
ParsedSurface parse_vtk_surface(const std::filesystem::path& path);
PolylineData parse_vtp_polylines(const std::filesystem::path& path);
TetData parse_vtu_tets(const std::filesystem::path& path);
WedgeData parse_vtu_wedges(const std::filesystem::path& path);

}  // namespace angio::formats::detail

#pragma once

#include <filesystem>
#include <string>

namespace angio {

/// What a file of VTK's legacy format (.vtk) holds by its header: "POLYDATA", "STRUCTURED_POINTS",
/// "UNSTRUCTURED_GRID", ...; empty if it is no such file.
std::string legacy_vtk_data_set(const std::filesystem::path& path);

/// Whether such a data set is a surface or has one: polygons, or a mesh that is no image.
bool is_legacy_surface(const std::string& data_set);

}  // namespace angio

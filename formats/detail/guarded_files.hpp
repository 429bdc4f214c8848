#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "formats/detail/surface_formats.hpp"
#include "formats/files.hpp"

/// VTK's XML files, parsed in a child process that reaches nothing but the file
/// (core/child_process.hpp).
///
/// @throws InputError naming the file, also where it ends the child
namespace angio::formats::detail {

ParsedSurface read_vtk_surface(const std::filesystem::path& path);
/// One child for all of them. @param take  gets each, in order
void read_vtp_surfaces(const std::vector<std::filesystem::path>& paths,
                       const std::function<void(ParsedSurface&&)>& take);
std::vector<PolylineData> read_vtp_polylines(const std::vector<std::filesystem::path>& paths);
TetData read_vtu_tets(const std::filesystem::path& path);
WedgeData read_vtu_wedges(const std::filesystem::path& path);

}  // namespace angio::formats::detail

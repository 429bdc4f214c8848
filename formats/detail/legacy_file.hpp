#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <filesystem>

namespace angio::formats::detail {

/// The polygons of a file of VTK's legacy format, or the outer faces of its grid. For a guarded
/// child only: see guarded_files.hpp.
///
/// VTK's reader makes less of a file that breaks off, or fills it up with zeros, without a word:
/// points and cells are counted before.
///
/// @throws InputError naming the file
vtkSmartPointer<vtkPolyData> read_legacy_polygons(const std::filesystem::path& path);

}  // namespace angio::formats::detail

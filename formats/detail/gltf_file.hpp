#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <filesystem>

namespace angio::formats::detail {

/// The triangles of all meshes of a glTF 2.0 scene (.glb, or .gltf with its bytes in base64), at
/// their first time and where their nodes place them, with glTF's axes turned as write_gltf()'s:
/// its (x, y, z) is (L, H, -P) of the patient. The unit stays: glTF's is the metre, but most files
/// of vessels hold millimetres. For a guarded child only: see guarded_files.hpp.
///
/// @throws InputError naming the file
vtkSmartPointer<vtkPolyData> read_gltf_polygons(const std::filesystem::path& path);

}  // namespace angio::formats::detail

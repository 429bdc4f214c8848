#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::formats {

/// A body of a scene: a surface, or a line where it has no triangles.
struct GltfBody {
  std::string name;
  TriangleMesh mesh;  ///< LPS [mm], at the first time; at least one triangle or two vertices
  std::array<double, 3> rgb{0.8, 0.8, 0.8};  ///< linear, [0, 1]
  double opacity = 1.0;                      ///< (0, 1]
  /// Its vertices at the scene's second time, third, ...: shape [time - 1][vertex]; empty: still.
  std::vector<std::vector<Vec3>> later;
};

struct GltfScene {
  std::vector<GltfBody> bodies;
  std::vector<double> times_s;  ///< rising; one or none: nothing moves
};

/// Writes a scene as glTF 2.0, .glb in one binary file or .gltf with its bytes in base64,
/// atomically; the same scene gives the same bytes. glTF's axes and unit: x to the patient's left,
/// y to the head, z to the front, in metres:
///
///     (x, y, z) = (L, H, -P) / 1000
///
/// A body that moves has a morph target for each later time, and one animation, "simulation", goes
/// linearly from each to the next in seconds.
///
/// Source: Khronos, "glTF 2.0 Specification" 2.0.1, 3.6 (accessors), 3.7.2.2 (morph targets),
///         3.11 (animations), 4.4 (GLB).
///
/// @throws Error (64) for another ending; InputError where a body is empty, or its later vertices
/// are
///         not as many as its first
void write_gltf(const std::filesystem::path& path, const GltfScene& scene);

}  // namespace angio::formats

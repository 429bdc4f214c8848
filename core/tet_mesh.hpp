#pragma once

#include <array>
#include <vector>

#include "core/vec3.hpp"

namespace angio {

using Tet = std::array<int, 4>;

/// A tetrahedral mesh in LPS [mm]; every tet is right-handed: tet_volume > 0.
struct TetMesh {
  std::vector<Vec3> vertices;  ///< [mm], shape [vertex_count]
  std::vector<Tet> tets;       ///< vertex indices, shape [tet_count]
};

/// V = (b - a) x (c - a) . (d - a) / 6 [mm^3]
ANGIO_HOST_DEVICE constexpr double tet_volume(const Vec3& a, const Vec3& b, const Vec3& c,
                                              const Vec3& d) {
  return dot(cross(b - a, c - a), d - a) / 6.0;
}

}  // namespace angio

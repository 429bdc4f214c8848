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

/// The volume [mm^3] of a wedge cut into three tetrahedra.
///
/// @param x  corners: a triangle, then the one that its normal points to
constexpr double cut_wedge_volume(const std::array<Vec3, 6>& x) {
  return tet_volume(x[0], x[1], x[2], x[3]) + tet_volume(x[1], x[2], x[3], x[4]) +
         tet_volume(x[2], x[3], x[4], x[5]);
}

}  // namespace angio

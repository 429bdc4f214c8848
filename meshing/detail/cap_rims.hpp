#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::meshing::detail {

/// A copy closed by a flat cap over each rim, with one new vertex inside each cap.
struct CappedMesh {
  TriangleMesh mesh;
  std::vector<int> id;  ///< per vertex: 0 wall, rim index + 1 on caps and rims
};
CappedMesh cap_rims(const TriangleMesh& open, const std::vector<int>& rim);

}  // namespace angio::meshing::detail

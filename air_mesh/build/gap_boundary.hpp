#pragma once

#include <optional>
#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::air_mesh {

/// A closed surface between two bodies' vertices, ready for a tetrahedral mesh.
struct GapBoundary {
  TriangleMesh shell;  ///< the region and caps over its rims, closed, normals outward
  int cap_first = 0;   ///< index of the first cap triangle in `shell`
};

/// Closes a region with caps over its rims, without new vertices.
///
/// @return nothing if a rim has no triangulation
std::optional<GapBoundary> close_region(const TriangleMesh& region);

/// The part of a wall that caps can close.
struct ClosedWall {
  GapBoundary boundary;
  std::vector<int> wall_vertex;  ///< of each vertex of the shell

  /// The wall's triangles in that part, over the wall's vertices.
  [[nodiscard]] std::vector<Triangle> wall_triangles() const;
};

/// Closes a wall with caps over its rims. Wall triangles that a cap crosses are left out.
///
/// @return nothing if that comes to no end
std::optional<ClosedWall> close_wall(const TriangleMesh& wall);

}  // namespace angio::air_mesh

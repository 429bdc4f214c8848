#pragma once

#include <string>
#include <vector>

#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"

namespace angio::air_mesh {

struct TetgenInput {
  std::vector<Vec3> vertices;        ///< [mm]; around the origin its predicates are sharpest
  std::vector<Triangle> triangles;   ///< boundary
  std::vector<Vec3> holes;           ///< a point inside each hollow [mm]
  std::vector<double> edge_lengths;  ///< wanted at each vertex [mm]; or empty
  std::string switches;              ///< TetGen's own
  std::string what;                  ///< is meshed, for messages: "the gap"
};

/// Runs TetGen in a child process, since it may crash, take all memory, or not end.
///
/// Source: Si, "TetGen, a Delaunay-based quality tetrahedral mesh generator", ACM TOMS 41 (2015)
/// @return the input's vertices first, then added ones; tetrahedra may be left-handed
/// @throws InternalError if TetGen fails, crashes, runs out of memory or takes more than `limit_s`
/// seconds of processor time
TetMesh run_tetgen(const TetgenInput& input, double limit_s);

}  // namespace angio::air_mesh

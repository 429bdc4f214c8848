#pragma once

#include <array>
#include <vector>

#include "air_mesh/tet_topology.hpp"

namespace angio::air_mesh {

/// Tetrahedra to be replaced by others over the same vertices, with the same outer faces.
struct TetFlip {
  static constexpr int kMost = 20;
  std::array<int, kMost> old{};
  std::array<Tet, kMost> fresh{};
  int old_count = 0, fresh_count = 0;
  double before = 0.0, after = 0.0;  ///< least quality
};

/// The best way to remove the edge between two corners of a tet, if it gains anything: the ring of
/// the tets around it is filled with the triangles whose tets' least quality is greatest, found by
/// dynamic programming. Rings of 3 are 3-2 flips, of 4 4-4 flips.
///
/// Source: Shewchuk, "Two Discrete Optimization Algorithms for the Topological Improvement of
/// Tetrahedral Meshes" (2002), section 3 (after Klincsek 1980).
///
/// @param x  [mm], shape [vertex]
/// @return old_count = 0 if the edge is on the boundary or its ring too long, or nothing is gained
TetFlip remove_edge(const TetTopology& mesh, const std::vector<Vec3>& x, int t, int corner_a,
                    int corner_b);

/// The best way to remove the face opposite a corner, and with it faces around it that lie between
/// the same two vertices, if it gains anything. One face is the 2-3 flip.
///
/// Source: Shewchuk 2002, section 4.
TetFlip remove_faces(const TetTopology& mesh, const std::vector<Vec3>& x, int t, int corner);

/// The flip of a tet's edges and faces with the greatest least quality; old_count = 0 if none
/// raises it.
TetFlip best_flip(const TetTopology& mesh, const std::vector<Vec3>& x, int t);

}  // namespace angio::air_mesh

#pragma once

#include <array>
#include <vector>

#include "core/triangle_mesh.hpp"

/// Gaps between a thin wire and a membrane, and how far both may move without passing each other.
namespace angio::simulation::detail {

/// A wire's segment from node `segment` to the next, and a triangle.
struct WirePair {
  int segment = 0, triangle = 0;
};

/// The gap of a pair along its direction.
struct WireGap {
  double distance = 0.0;  ///< [mm]
  double share = 0.0;     ///< of the segment, to its closest point, [0, 1]
  Vec3 direction;         ///< unit, from the triangle to the segment; zero where they touch
};

/// Closest points of the segment (a, b) and a triangle: the least over its ends and the triangle,
/// and itself and the triangle's edges. A segment that runs through the triangle keeps the distance
/// from its edges: see `runs_through`.
WireGap wire_gap(const Vec3& a, const Vec3& b, const std::array<Vec3, 3>& corners);

/// Does the segment (a, b) cut the triangle?
///
/// Source: Moeller, Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", J. Graphics Tools
/// 2 (1997)
bool runs_through(const Vec3& a, const Vec3& b, const std::array<Vec3, 3>& corners);

/// Does the closed surface go around the point? By the sum of its triangles' solid angles.
///
/// Source: Van Oosterom, Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125
bool encloses(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x, const Vec3& p);

/// Positions of wire and membrane, and how they move.
struct WireMotion {
  const std::vector<Vec3>& wire;
  const std::vector<Vec3>& wire_by;  ///< [mm], shape [node]
  const std::vector<Vec3>& membrane;
  const std::vector<Vec3>& membrane_by;  ///< [mm], shape [vertex]
};

/// The part of the motion, in (0, 1], along which a pair's gap stays above a twentieth; it ends
/// where less than a tenth is left.
///
/// Source: Li, Kaufman, Jiang, "Codimensional Incremental Potential Contact", ACM TOG 40 (2021),
/// Algorithm 1 (additive continuous collision detection)
double free_share(const WireMotion& motion, const Triangle& triangle, const WirePair& pair);

}  // namespace angio::simulation::detail

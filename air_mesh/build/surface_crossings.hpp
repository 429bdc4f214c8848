#pragma once

#include <array>
#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::air_mesh {

/// Pairs of triangles of one mesh that cross (those that share a vertex or an edge only touch
/// there and are left out unless they overlap), in ascending order. Exact predicates.
std::vector<std::array<int, 2>> self_intersections(const TriangleMesh& mesh);

/// The same, only the pairs with a triangle that is marked.
std::vector<std::array<int, 2>> self_intersections_of(const TriangleMesh& mesh,
                                                      const std::vector<char>& marked);

/// Pairs (triangle of a, triangle of b) that meet, touching included, in ascending order. Exact.
std::vector<std::array<int, 2>> intersections(const TriangleMesh& mesh_a,
                                              const TriangleMesh& mesh_b);

}  // namespace angio::air_mesh

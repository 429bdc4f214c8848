#pragma once

#include <array>
#include <vector>

#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {

/// A part of a draft that is worked on by itself.
struct Patch {
  SurfaceDraft draft;          ///< `origin` holds the whole's vertex indices
  std::vector<char> free;      ///< per vertex of `draft`: may move; the others tie it to the rest
  std::vector<char> in_patch;  ///< per triangle of the whole
  [[nodiscard]] bool empty() const { return draft.mesh.triangles.empty(); }
};

/// The triangles within some rings around marked vertices. Vertices that the rest of the surface
/// uses are not free.
///
/// @param marked  per vertex of the whole
Patch take_patch(const SurfaceDraft& whole, const std::vector<char>& marked, int ring_count);

/// Replaces the patch's triangles by those of the worked patch.
///
/// @return per triangle of the whole, now: 1 if it is of the patch
std::vector<char> put_back(SurfaceDraft& whole, const Patch& patch);

/// Marks the corners of triangles.
std::vector<char> mark_corners(const TriangleMesh& mesh,
                               const std::vector<std::array<int, 2>>& triangle_pairs);

/// Marks the neighbours of marked vertices as well, ring by ring.
void grow(const TriangleMesh& mesh, std::vector<char>& marked, int ring_count);

/// Vertices around which the kept triangles are more than one fan, per vertex.
std::vector<char> vertices_of_several_fans(const TriangleMesh& mesh, const std::vector<char>& kept);

}  // namespace angio::meshing::detail

#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"
#include "meshing/detail/surface_query.hpp"

namespace angio::meshing::detail {

/// The diameter of the largest ball that touches the wall at a point from the side that `inward`
/// shows; 0 if the way across leaves through an opening.
///
/// @param triangle  that the point lies on
double touching_ball(const ClosestPoint& wall, const Vec3& at, const Vec3& inward, int triangle);

/// Whether the outside of each of some triangles is a hollow that the surface closes around: the
/// middle of the ball that touches it there sees the wall in 11 of 14 directions, the faces and
/// corners of a cube, within three times the ball's diameter. A tube's axis does, but for the two
/// ways along it.
std::vector<char> face_a_hollow(const TriangleMesh& mesh, const std::vector<std::size_t>& samples);

/// The share of a surface's area whose outside is such a hollow, by 400 samples.
double hollow_share_of(const TriangleMesh& mesh, double area);

/// Above this share a surface is that of a vessel's wall.
inline constexpr double kWallShare = 0.25;

/// The wall of the hollow in a vessel's wall, turned so that its normals leave the hollow: the
/// triangles that face it, their rough borders smoothed, in pieces of at least a twentieth of it,
/// and what they surround: a mound's slopes look out of the vessel's ends.
/// Open where the vessel is; empty if there is none.
TriangleMesh hollow_of(const TriangleMesh& mesh);

}  // namespace angio::meshing::detail

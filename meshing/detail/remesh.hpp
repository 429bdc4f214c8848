#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"
#include "meshing/detail/surface_target.hpp"

namespace angio::meshing::detail {

struct Plane {
  Vec3 origin;  ///< [mm]
  Vec3 normal;  ///< unit
  [[nodiscard]] double signed_distance(const Vec3& p) const { return dot(p - origin, normal); }
};

/// A surface on its way from raw triangles to well-shaped ones.
struct SurfaceDraft {
  TriangleMesh mesh;
  std::vector<double> edge_length;  ///< wanted at each vertex [mm], shape [vertex_count]
  std::vector<int> rim;             ///< index into `rim_planes` of border vertices, -1 elsewhere
  std::vector<Plane> rim_planes;
};

/// Remeshes towards equilateral triangles of the wanted edge lengths, vertices on the target.
///
///     split edges > 4/3 L, collapse edges < 4/5 L, flip towards valence 6 (4 on rims),
///     move vertices to the area-weighted centre of their star within the tangent plane, project
///
/// Source: Botsch, Kobbelt, "A remeshing approach to multiresolution modeling", SGP 2004, section
/// 4. Departures: L varies over the surface; every step is refused that turns a triangle by more
/// than about 70 degrees from the surface or spoils its angles; the last rounds flip, collapse and
/// move for the least angle; rim vertices stay in their planes.
void remesh(SurfaceDraft& draft, const SurfaceTarget& target, int round_count);

/// Remeshes some vertices only, as a membrane that need not lie on a target.
///
/// @param loose  per vertex; the others do not move
void remesh_membrane(SurfaceDraft& draft, const std::vector<char>& loose, int round_count);

/// Taubin's smoothing along the normals (lambda 0.5, mu -0.53): noise goes, volume stays. Rims
/// move within their planes.
///
/// Source: Taubin, "A signal processing approach to fair surface design", SIGGRAPH 1995, Eq. 5-8
void smooth(SurfaceDraft& draft, int iteration_count);

/// Moves vertices along their normals until triangles lie as much outside as inside the target, so
/// that flat triangles enclose the volume of the curved surface. A regular n-gon in a circle would
/// lose (2 pi / n)^2 / 6 of the area: 2.6 % at n = 16.
void balance_volume(SurfaceDraft& draft, const SurfaceTarget& target);

/// Least angle of a triangle [degrees]; 0 if degenerate.
double least_angle_degrees(const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace angio::meshing::detail

#pragma once

#include <array>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "meshing/detail/surface_target.hpp"
#include "meshing/detail/widening.hpp"

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
  std::vector<char> membrane;       ///< vertices that need not lie on the target
  std::vector<int> origin;          ///< vertex of a larger draft that it is, -1: new; or empty
  std::vector<Plane> rim_planes;
  const Widening* widening = nullptr;  ///< how lengths count, not owned; null: as they are
};

/// Remeshes towards equilateral triangles of the wanted edge lengths, vertices on the target.
///
///     split edges > 4/3 L, collapse edges < 4/5 L, flip towards valence 6 (4 on rims),
///     move vertices to the area-weighted centre of their star within the tangent plane, project
///
/// Source: Botsch, Kobbelt, "A remeshing approach to multiresolution modeling", SGP 2004, section
/// 4. Departures: L varies over the surface; every step is refused that turns a triangle by more
/// than about 70 degrees from the surface or spoils its angles; the last rounds flip, collapse and
/// move for the least angle; rim vertices stay in their planes; where the lumen will be widened,
/// lengths and angles are those that count (Widening).
void remesh(SurfaceDraft& draft, const SurfaceTarget& target, int round_count);

/// The same for some vertices only.
///
/// @param free  per vertex; the others do not move
void remesh_part(SurfaceDraft& draft, const SurfaceTarget& target, const std::vector<char>& free,
                 int round_count);

/// Remeshes some vertices only, as a membrane that need not lie on a target.
///
/// @param free  per vertex; the others do not move
void remesh_membrane(SurfaceDraft& draft, const std::vector<char>& free, int round_count);

/// Raises the least angles of a surface that is free of crossings and stays so: flips, moves,
/// collapses and splits around triangles below 28 degrees, each only if the least angle there
/// grows. Vertices keep their signed distance from the target; where that cannot be, a few become
/// parts of a membrane.
///
/// @return triangles that stay below 21 degrees, each as a pair with itself
std::vector<std::array<int, 2>> improve_angles(SurfaceDraft& draft, const SurfaceTarget& target);

/// Takes membranes, and what lies within three rings of them, back to the target, as far from it as
/// the surface around: those with which no triangle crosses, folds or has an angle below 21
/// degrees.
void bring_membranes_back(SurfaceDraft& draft, const SurfaceTarget& target);

/// Taubin's smoothing along the normals (lambda 0.5, mu -0.53): noise goes, volume stays. Then
/// vertices move until triangles lie as much outside as inside the target, so that flat triangles
/// enclose the volume of the curved surface. Rims move within their planes; where triangles would
/// cross, vertices stay.
///
/// Source: Taubin, "A signal processing approach to fair surface design", SIGGRAPH 1995, Eq. 5-8
/// @param tolerance  [mm] distance from the target that Taubin's smoothing may reach; or infinite
void smooth(SurfaceDraft& draft, const SurfaceTarget& target, int iteration_count,
            double tolerance);

/// Least angle of a triangle [degrees]; 0 if degenerate.
double least_angle_degrees(const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace angio::meshing::detail

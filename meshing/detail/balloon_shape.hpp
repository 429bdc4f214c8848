#pragma once

#include <vector>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "meshing/detail/surface_target.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing::detail {

/// What is asked of a balloon, with every default filled in.
struct BalloonPlan {
  double nominal_radius = 0.0;   ///< [mm]
  double cylinder_length = 0.0;  ///< [mm]
  double start_radius = 0.0;     ///< [mm] not exceeded
  double middle_abscissa = 0.0;  ///< [mm] on the path
  int ring_count = 0;
  int ring_vertex_count = 0;
  int guidewire_node_count = 0;

  /// From pole to pole: each end is a hemisphere. [mm]
  [[nodiscard]] double total_length() const { return cylinder_length + 2.0 * nominal_radius; }
};

/// Rings of a capsule at equal steps along its meridian, from pole to pole.
struct CapsuleRings {
  std::vector<double> position;  ///< along the axis from the proximal pole [mm]
  std::vector<double> radius;    ///< of the vertices [mm]
};
/// The polygon of a ring has the area of the circle it stands for:
///
///     rho = R sqrt( (2 pi / n) / sin(2 pi / n) )
CapsuleRings capsule_rings(const BalloonPlan& plan);

/// Triangles of rings and two poles with alternating diagonals, normals outward. Vertex k of ring i
/// is i * ring_vertex_count + k; then the proximal and the distal pole.
std::vector<Triangle> capsule_triangles(int ring_count, int ring_vertex_count);

/// A curve with a frame that turns as little as possible along it.
struct FramedAxis {
  std::vector<Vec3> points;
  std::vector<Vec3> tangents, normals;  ///< unit, at right angles
  std::vector<double> abscissa;         ///< arc length from the first point [mm]
  std::vector<double> wall_distance;    ///< to the wall, positive inside the lumen [mm]
};

/// Places the balloon along a path inside a lumen.
///
/// The axis is the path smoothed by a Gaussian as far as the balloon's rings ask for (they must not
/// cross at bends) while it stays inside the lumen. Each ring is as wide as wanted, or as the wall
/// lets it: the gap to the wall is at least 15 % of the axis's distance from the wall and 0.02 mm.
///
/// @param wall  of the lumen
/// @throws InputError if a ring would have to be thinner than 0.10 mm in radius
Balloon shape_balloon(const BalloonPlan& plan, const CenterlinePath& path,
                      const SurfaceTarget& wall);

/// The start shape again with every ring thinner by a factor.
void shrink_start(Balloon& balloon, const BalloonPlan& plan, double factor);

}  // namespace angio::meshing::detail

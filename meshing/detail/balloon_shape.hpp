#pragma once

#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "meshing/detail/surface_target.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing::detail {

inline constexpr double kLeastStartRadius = 0.10;  ///< [mm] thinner than any guidewire (0.18 mm)

/// What is asked of a balloon, with every default filled in.
struct BalloonPlan {
  double nominal_diameter = 0.0;  ///< [mm] its name
  double rest_radius = 0.0;       ///< [mm] of the unloaded cylinder
  double cylinder_length = 0.0;   ///< [mm]
  double start_radius = 0.0;      ///< [mm] not exceeded where folds are not meshed
  double middle_abscissa = 0.0;   ///< [mm] on the path
  double slimness = 1.0;          ///< share of the room around the axis that is used, (0, 1]
  int fold_count = 0;             ///< 0: a tube of the start radius, folds not meshed
  double shaft_radius = 0.0;      ///< [mm] inside the folds
  double fold_gap = 0.0;          ///< [mm] at least between layers, and to the shaft
  int ring_count = 0;             ///< folds may ask for more
  int ring_vertex_count = 0;      ///< folds may ask for more
  int guidewire_node_count = 0;

  /// From pole to pole: each end is a hemisphere. [mm]
  [[nodiscard]] double total_length() const { return cylinder_length + 2.0 * rest_radius; }
};

/// Rings of a capsule at equal steps along its meridian, from pole to pole.
struct CapsuleRings {
  std::vector<double> position;  ///< along the axis from the proximal pole [mm]
  std::vector<double> radius;    ///< of the vertices [mm]
  std::vector<double> past_end;  ///< meridian beyond the cylinder's end, 0 on it [mm]
};
/// The polygon of a ring has the area of the circle it stands for:
///
///     rho = R sqrt( (2 pi / n) / sin(2 pi / n) )
CapsuleRings capsule_rings(const BalloonPlan& plan);

/// Triangles of rings and two poles with alternating diagonals, normals outward. Vertex k of ring i
/// is i * ring_vertex_count + k; then the proximal and the distal pole.
std::vector<Triangle> capsule_triangles(int ring_count, int ring_vertex_count);

struct ShapedBalloon {
  Balloon balloon;
  std::vector<std::string> warnings;
};

/// Places the balloon along a path inside a lumen; see fit_axis for the axis and the gap to the
/// wall. Unfolded, each ring is as wide as wanted, or as the wall lets it. Folded, the section is
/// the same along the whole cylinder, wound more tightly if the wall asks for it, and opens towards
/// the poles.
///
/// @param wall  of the lumen
/// @throws InputError if there is not enough room
ShapedBalloon shape_balloon(const BalloonPlan& plan, const CenterlinePath& path,
                            const SurfaceTarget& wall);

}  // namespace angio::meshing::detail

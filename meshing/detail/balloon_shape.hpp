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
  BalloonEnds ends = BalloonEnds::hemispheres;
  double neck_radius = 0.0;      ///< [mm] of cones' narrow ends, on the shaft
  double cylinder_length = 0.0;  ///< [mm]
  double start_radius = 0.0;     ///< [mm] not exceeded where folds are not meshed
  double middle_abscissa = 0.0;  ///< [mm] on the path
  double slimness = 1.0;         ///< share of the room around the axis that is used, (0, 1]
  int fold_count = 0;            ///< 0: a tube of the start radius, folds not meshed
  double shaft_radius = 0.0;     ///< [mm] inside the folds
  double fold_gap = 0.0;         ///< [mm] at least between layers, and to the shaft
  int ring_count = 0;            ///< folds may ask for more
  int ring_vertex_count = 0;     ///< folds may ask for more
  int guidewire_node_count = 0;

  /// From the cylinder to the pole, along the axis: a hemisphere, or a cone and its neck. [mm]
  [[nodiscard]] double end_length() const;
  /// From pole to pole [mm].
  [[nodiscard]] double total_length() const { return cylinder_length + 2.0 * end_length(); }
  /// Between the poles, or the necks' inner ends, along the unloaded membrane [mm].
  [[nodiscard]] double meridian() const;
  /// The meridian from the cylinder's end to where the end is as narrow as `radius` [mm].
  [[nodiscard]] double meridian_to(double radius) const;
  /// The way along the axis of so much meridian beyond the cylinder's end [mm].
  [[nodiscard]] double rise(double past_end) const;
};

/// Cones' rings on the neck; they move as one.
inline constexpr int kNeckRings = 2;

/// Rings of an unloaded balloon, from pole to pole. With hemispheres at equal steps along the
/// meridian; with cones at equal steps on the cylinder, and on the cones at steps in proportion to
/// the radius, so that the triangles keep their shape.
struct BalloonRings {
  std::vector<double> position;  ///< along the axis from the proximal pole [mm]
  std::vector<double> radius;    ///< of the vertices [mm]
  std::vector<double> past_end;  ///< meridian beyond the cylinder's end, 0 on it [mm]
};
/// The polygon of a ring has the area of the circle it stands for:
///
///     rho = R sqrt( (2 pi / n) / sin(2 pi / n) )
BalloonRings balloon_rings(const BalloonPlan& plan);

/// Triangles of rings and two poles with alternating diagonals, normals outward. Vertex k of ring i
/// is i * ring_vertex_count + k; then the proximal and the distal pole.
std::vector<Triangle> balloon_triangles(int ring_count, int ring_vertex_count);

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

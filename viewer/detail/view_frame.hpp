#pragma once

#include <optional>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"

/// Where to look from. Plain geometry, no renderer.
namespace angio::viewer::detail {

/// A parallel projection. `right` = direction x up.
struct ViewFrame {
  Vec3 focus;                   ///< middle of the picture, LPS [mm]
  Vec3 direction{0, 1, 0};      ///< unit, from the eye into the scene
  Vec3 up{0, 0, 1};             ///< unit, at right angles to direction
  double half_width_mm = 1.0;   ///< shown to each side of the focus, > 0
  double half_height_mm = 1.0;  ///< shown above and below, > 0

  [[nodiscard]] Vec3 right() const { return cross(direction, up); }
};

/// The whole tree at its broadest: along the axis of least variance of the surface's points
/// (principal component analysis), from the patient's front, with the head up where that is
/// possible.
///
/// @param mesh    at least one vertex; none gives the default frame
/// @param rather  unit: looked along instead where the tree is hardly deeper along it (of at most
///                twice the least variance): of a straight vessel the side that shows its lesion
ViewFrame frame_tree(const TriangleMesh& mesh, const std::optional<Vec3>& rather = {});

/// Opens a frame to hold a circle of the picture, too.
/// @param radius_mm  > 0
void include_circle(ViewFrame& frame, const Vec3& centre, double radius_mm);

/// The lesion in profile: at right angles to the vessel there, flow from left to right, turned
/// about the vessel to where the lumen looks narrowest (as one picks the working view in
/// angiography), unless other vessels are in the way or the vessel bends out of the picture.
///
/// @param wall         region to be shown, at least one vertex
/// @param other        what else is near: may hide the wall
/// @param path         line through the lesion
/// @param abscissa_mm  of the lesion
ViewFrame frame_lesion(const TriangleMesh& wall, const TriangleMesh& other,
                       const CenterlinePath& path, double abscissa_mm);

/// The part of `lumen` within `radius_mm` of `center` that does not belong to `wall` (no triangle
/// all of whose corners are the wall's). The wall's corners are found by their place, to 1e-4 mm.
TriangleMesh surroundings(const TriangleMesh& lumen, const TriangleMesh& wall, const Vec3& center,
                          double radius_mm);

/// The middle of a mesh's bounding box, and half its diagonal [mm].
struct Bounds {
  Vec3 center;
  double radius_mm = 0.0;
};
Bounds bounds(const TriangleMesh& mesh);

}  // namespace angio::viewer::detail

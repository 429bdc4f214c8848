#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio {

/// An opening of a surface.
struct SurfaceRim {
  std::vector<int> loop;       ///< its vertices, from boundary_loops
  Vec3 centre;                 ///< of the area that a fan over it has
  Vec3 normal;                 ///< unit, leaves the lumen
  double diameter_mm = 0.0;    ///< of the circle with the opening's area
  double unevenness_mm = 0.0;  ///< largest distance of a vertex from the plane through the centre
  /// How far the wall runs out through the opening: 1 at the end of a tube, whether it is cut
  /// straight or aslant, 0 at a hole in a flat wall.
  ///
  ///     w = sum over the rim of ds (c . n) / max(2 sqrt(pi area), perimeter / 2)
  ///
  /// with c the unit vector in the wall, across the rim and away from it: the pull of a wall under
  /// unit tension through the opening, over that of a tube of this width. A round hole of radius a
  /// in a tube of radius R has a / 2R, in a ball a / R; the mouth of a cone that opens by an angle
  /// has its cosine. Jags of the rim do not change it. A rim that leans inwards, as where the edge
  /// of a rounded cap is left, is measured again a quarter of its radius inside, and half of it,
  /// where nearly all of the wall must run out.
  double wall_along = 0.0;
};

/// From this share of `wall_along` on an opening is the end of a vessel, and no hole in its wall.
inline constexpr double kVesselEnd = 0.5;

/// Every opening of a surface whose triangles are turned alike, the longest rim first.
std::vector<SurfaceRim> surface_rims(const TriangleMesh& mesh);

}  // namespace angio

#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"
#include "meshing/detail/healthy_vessel.hpp"
#include "meshing/wall_layers.hpp"

namespace angio::meshing::detail {

/// The way from a vertex of the lumen to the outside of the wall.
struct WallColumn {
  std::vector<Vec3> points;      ///< from the lumen outward
  std::vector<double> length;    ///< from the lumen to each point [mm]
  std::vector<double> distance;  ///< of each point from the healthy lumen here [mm]
  double plaque = 0.0;           ///< length up to the healthy lumen [mm], 0 where it is no narrower
  double thickness = 0.0;        ///< of the wall beyond that [mm], by distance
  double missing = 0.0;          ///< of the wanted thickness [mm], where there is no room for it
  double room = 1.0;             ///< share of the way that there is room for
};

/// Walks from every vertex of a lumen's surface to the outside of the wall: straight away from the
/// lumen as long as it is inside the healthy one, then up the distance from that. Such ways do not
/// cross, and in creases between branches they turn outward together. Outside narrow stretches, and
/// where it is wider, the lumen itself, smoothed, counts as healthy.
///
/// Where the lumen does not lie around its lines (an aneurysm, a vessel without a line of its own,
/// one that touches another's), the lines do not lead: the way goes straight out, as long as the
/// wall is thick for half the lumen's own width there. Half the way to the next vessel is room.
///
/// @param thickness_per_radius  of the wall
std::vector<WallColumn> grow_columns(const TriangleMesh& lumen, const HealthyVessel& healthy,
                                     double thickness_per_radius);

/// The place on a column at a depth: up to the plaque's thickness by length, then by distance.
Vec3 place_at(const WallColumn& column, double depth);

}  // namespace angio::meshing::detail

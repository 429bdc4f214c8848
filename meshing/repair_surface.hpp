#pragma once

#include <string>
#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::meshing {

struct SurfaceRepairOptions {
  bool keep_all_pieces = false;  ///< otherwise those of at least 5 % of the largest one's area
};

/// One kind of repair that was made.
struct SurfaceRepair {
  std::string what;         ///< "holes in the wall filled", ...
  int count = 0;            ///< how often
  Vec3 where;               ///< one of the places, that of the largest where there is a size [mm]
  bool is_routine = false;  ///< comes with the file's format: a vertex of its own for each corner
  double size_mm = 0.0;     ///< diameter or extent of the largest; 0 where it says nothing

  void scale(double factor) {  ///< to another unit
    where *= factor;
    size_mm *= factor;
  }
};
/// "3 holes in the wall filled, the largest of 0.80 mm at (1.00, 2.00, 3.00) mm"
std::string to_text(const SurfaceRepair& repair);

struct RepairedSurface {
  TriangleMesh mesh;
  std::vector<SurfaceRepair> repairs;  ///< in the order in which they were made; none if sound
};

/// Makes a manifold surface that a lumen can have of one that arrives broken.
///
/// In this order: points that coincide are merged, degenerate and repeated triangles dropped,
/// T-junctions joined, sheets that hang on the wall cut off, small twists cut out, triangles turned
/// alike and outward, edges and corners where several sheets meet taken apart, the outside of a
/// wall left out, pieces that cross each other united, small pieces left out, holes in the wall
/// filled, triangles that cross cut out and closed anew or, where they are many, the inside
/// contoured, and edges that are longer than the lumen is wide split where they are many. No step
/// loses volume: what is inside at the end is where the winding number was above 0, to 2 %.
///
/// An opening is the end of a vessel and stays, where half of the wall around it or more runs out
/// through it (SurfaceRim::wall_along); otherwise it is a hole in the wall, as every one of three
/// edges is, and one a hundred times narrower than the widest vessels. So each rim of the result is
/// an end. A sound surface comes back as it is.
///
/// @throws InputError naming what cannot be repaired: numbers that are not finite, missing
///         vertices, one-sided surfaces, crossings over much of the surface
RepairedSurface repair_surface(const TriangleMesh& surface,
                               const SurfaceRepairOptions& options = {});

}  // namespace angio::meshing

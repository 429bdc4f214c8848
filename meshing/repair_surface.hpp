#pragma once

#include <string>
#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::meshing {

struct SurfaceRepairOptions {
  bool keep_all_pieces = false;  ///< otherwise the largest piece only
};

/// One kind of repair that was made.
struct SurfaceRepair {
  std::string what;         ///< "holes in the wall filled", ...
  int count = 0;            ///< how often
  Vec3 where;               ///< one of the places [mm]
  bool is_routine = false;  ///< comes with the file's format: a vertex of its own for each corner
};
/// "3 holes in the wall filled, one at (1.0, 2.0, 3.0) mm"
std::string to_text(const SurfaceRepair& repair);

struct RepairedSurface {
  TriangleMesh mesh;
  std::vector<SurfaceRepair> repairs;  ///< in the order in which they were made; none if sound
};

/// Makes a manifold surface that a lumen can have of one that arrives broken.
///
/// In this order: points that coincide are merged, degenerate and repeated triangles dropped,
/// T-junctions joined, sheets that hang on the wall cut off, triangles turned alike and outward,
/// edges and corners where several sheets meet taken apart, pieces that cross each other united,
/// small pieces left out, holes in the wall filled, triangles that cross cut out and closed anew.
/// Openings across a vessel stay open: there the wall runs along the opening's axis, at a hole in
/// the wall it runs across. A sound surface comes back as it is.
///
/// @throws InputError naming what cannot be repaired: numbers that are not finite, missing
///         vertices, one-sided surfaces, crossings over much of the surface
RepairedSurface repair_surface(const TriangleMesh& surface,
                               const SurfaceRepairOptions& options = {});

}  // namespace angio::meshing

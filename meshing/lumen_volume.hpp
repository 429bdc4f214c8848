#pragma once

#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing {

struct LumenVolumeOptions {
  double edge_ratio = 1.0;   ///< edges inside over those of the wall, [0.5, 5]
  int tet_budget = 2000000;  ///< upper bound, [1000, 5e7]; inner edges are lengthened to keep it
  double least_dihedral_degrees = 18.0;  ///< sharper tetrahedra are worked on, [5, 25]

  void validate() const;
};

/// Names of boundary faces, as vmtkmeshgenerator gives them in CellEntityIds (0 is the volume).
constexpr int kWallEntityId = 1;
constexpr int kInletEntityId = 2;  ///< outlet n, n = 1, 2, ... in path order, is 2 + n

/// The lumen filled with tetrahedra, for flow solvers.
struct LumenVolume {
  /// Vertices: those of the wall in the open lumen's order, then those of the caps, then inner
  /// ones.
  TetMesh mesh;
  std::vector<Triangle> boundary;  ///< the mesh's outer faces, normals outward: the wall's
                                   ///< triangles in the open lumen's order, then those of the caps
  std::vector<int> boundary_entity_id;  ///< of each boundary face
  double min_dihedral_degrees = 0.0;
  double max_dihedral_degrees = 0.0;
  int sharp_tet_count = 0;  ///< tetrahedra with a dihedral angle below 12 degrees
  double volume_mm3 = 0.0;
  std::vector<std::string> warnings;
};

/// Fills a lumen with tetrahedra that keep the triangles of its wall.
///
/// TetGen's constrained Delaunay refinement, its edges graded from the wall's inward, then moves,
/// swaps, contractions and splits around the worst tetrahedra. Caps get triangles like the wall's.
/// The same lumen and options give the same bytes.
///
/// @throws InputError if the lumen is not watertight or crosses itself
LumenVolume mesh_lumen_volume(const LumenMesh& lumen, const LumenVolumeOptions& options,
                              const Progress& progress = {});

}  // namespace angio::meshing

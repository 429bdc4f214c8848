#pragma once

namespace angio::air_mesh {

/// What happened to the air mesh since the last report, and how it is now.
struct AirReport {
  int tet_count = 0;
  int inverted_count = 0;   ///< tets without a positive volume
  double min_volume = 0.0;  ///< [mm^3]; 0 without tets
  int flip_count = 0;       ///< edges and faces removed
  int point_count = 0;      ///< points in the air
  int rebuild_count = 0;    ///< whole meshes built again
};

}  // namespace angio::air_mesh

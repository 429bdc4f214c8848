#pragma once

namespace angio::air_mesh {

/// What happened to the air mesh since the last report, and how it is now.
struct AirReport {
  int tet_count = 0;
  int left_out_count = 0;       ///< tets folded into others; not among those above
  double left_out_share = 0.0;  ///< of the gap's volume
  double min_volume = 0.0;      ///< of the tets that are not left out [mm^3]; 0 without tets
  int inverted_count = 0;       ///< among them, tets without a positive volume
  int flip_count = 0;           ///< edges and faces removed
  int point_count = 0;          ///< points in the air
  int rebuild_count = 0;        ///< whole meshes built again
};

}  // namespace angio::air_mesh

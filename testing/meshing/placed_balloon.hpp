#pragma once

#include <cmath>
#include <utility>

#include "core/units.hpp"
#include "meshing/meshing.hpp"
#include "testing/meshing/analytic_vessels.hpp"

namespace angio::meshing::test {

/// A vessel with its mesh and the balloon placed in it.
struct PlacedCase {
  Vessel vessel;
  LumenMesh lumen;
  BalloonSetup setup;
};

/// A balloon with cones and necks, of rings enough for them.
inline BalloonOptions with_cones() {
  BalloonOptions options;
  options.ends = BalloonEnds::cones;
  options.ring_count = 32;
  return options;
}

inline PlacedCase place(Vessel vessel, double abscissa, double lesion_length,
                        double reference_diameter, const BalloonOptions& options = with_cones()) {
  PlacedCase result{std::move(vessel), {}, {}};
  result.lumen = mesh_lumen(result.vessel.level_set, result.vessel.tree, {});
  result.setup = place_balloon(result.lumen, result.vessel.tree, result.vessel.tree.paths[0],
                               abscissa, lesion_length, reference_diameter, options);
  return result;
}

inline Vessel stenosed_tube(double severity = 0.6) {
  return make_tube(36.0, 0.3, stenosis(1.5, 18.0, 5.0, severity));
}
/// How often a closed surface goes around a point: the sum of its triangles' solid angles over 4
/// pi. Source: Van Oosterom, Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125.
inline double winding_number(const TriangleMesh& mesh, const Vec3& point) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[std::size_t(t[0])] - point;
    const Vec3 b = mesh.vertices[std::size_t(t[1])] - point;
    const Vec3 c = mesh.vertices[std::size_t(t[2])] - point;
    sum += 2.0 * std::atan2(dot(a, cross(b, c)), norm(a) * norm(b) * norm(c) + dot(a, b) * norm(c) +
                                                     dot(b, c) * norm(a) + dot(c, a) * norm(b));
  }
  return sum / (4.0 * units::kPi);
}

inline double sum_of_tets(const TetMesh& mesh) {
  double sum = 0.0;
  for (const Tet& t : mesh.tets)
    sum += tet_volume(mesh.vertices[std::size_t(t[0])], mesh.vertices[std::size_t(t[1])],
                      mesh.vertices[std::size_t(t[2])], mesh.vertices[std::size_t(t[3])]);
  return sum;
}

/// Vessels with a balloon, placed once: many tests look at them.
inline const PlacedCase& stenosed() {
  static const PlacedCase kCase = place(stenosed_tube(), 18.0, 8.0, 3.0);
  return kCase;
}
inline const PlacedCase& bent() {
  static const PlacedCase kCase = place(make_arc(1.5, 7.0, 2.8, 0.3), 9.8, 2.0, 3.0);
  return kCase;
}
inline const PlacedCase& forked() {
  static const PlacedCase kCase = place(make_fork(1.5, 1.2, 16.0, 16.0, 0.6, 0.3), 16.0, 2.0, 2.5);
  return kCase;
}

}  // namespace angio::meshing::test

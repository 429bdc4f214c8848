#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"
#include "simulation/newton/newton.hpp"

namespace angio::simulation::detail {

/// A cylinder along z with hemispherical ends, or a short piece of an endless one between planes,
/// in rings of equally many vertices. The strips between the rows of vertices along the cylinder
/// stay flat, halved by diagonals that change direction from ring to ring.
///
/// The cylinder is the prism about the circle of the wanted radius. A flat strip of it carries a
/// tension of p times its distance from the axis, so that in the prism every stretch of the closed
/// form for the round tube is a state of rest, whatever the number of strips.
struct Capsule {
  TriangleMesh mesh;               ///< closed, normals outward; its middle is the origin
  std::vector<Triangle> membrane;  ///< the triangles of `mesh` that are membrane
  int around = 0;                  ///< vertices of a ring; ring r begins at vertex r * around
  int first_ring = 0, middle_ring = 0, last_ring = 0;  ///< of the cylinder
  int low_pole = 0, high_pole = 0;                     ///< vertices on the axis
  double circle_factor = 1.0;                          ///< radius of the vertices over the radius
  double length = 0.0;                                 ///< of the cylinder that is meshed [mm]
};

/// @param around  >= 8
Capsule make_capsule(double radius, double length, int around);

/// A few rings between two planes that are no membrane: what an endless tube does everywhere.
Capsule make_tube_piece(double radius, int around);

/// What of a capsule does not move so that its rigid motions are excluded, without holding it
/// against any load (see minimize()).
std::vector<char> without_rigid_motion(const Capsule& capsule);

/// Keeps the vertices of the tube piece's high end in one plane with its pole: stiff springs along
/// z.
class PlaneTerm final : public EnergyTerm {
 public:
  /// @param stiffness  of a spring [uN/mm]
  PlaneTerm(const Capsule& capsule, double stiffness);
  [[nodiscard]] double value(const std::vector<Vec3>& x) const override;
  void add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const override;

 private:
  int pole_, begin_, end_;
  double stiffness_;
};

}  // namespace angio::simulation::detail

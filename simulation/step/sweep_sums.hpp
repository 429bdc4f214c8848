#pragma once

#include "simulation/step/bounded_motion.hpp"
#include "simulation/step/pair_forces.hpp"

/// What the sweeps share: their sums, and the gas.
namespace angio::simulation::detail {

/// Six times the volume of the tetrahedron of a balloon triangle and the origin [mm^3].
template <class Real>
ANGIO_HOST_DEVICE inline double six_volumes(const StepView<Real>& s, int t) {
  const Vec3T<Real>&a = s.motion.x[s.balloon.triangles[3 * t]],
        &b = s.motion.x[s.balloon.triangles[3 * t + 1]],
        &c = s.motion.x[s.balloon.triangles[3 * t + 2]];
  const Vec3T<double> p{a.x, a.y, a.z}, q{b.x, b.y, b.z}, r{c.x, c.y, c.z};
  return dot(p, cross(q, r));
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline double enclosed_volume(Team& team, const StepView<Real>& s) {
  double total[1];
  team.template sum<1, 1>(
      s.balloon.triangle_count,
      [&](int t, const auto&, auto* part) { part[0] += six_volumes(s, t); }, total);
  return total[0] / 6.0;
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline void measure_gas(Team& team, const StepView<Real>& s, StepStatus& status) {
  status.volume = enclosed_volume(team, s);
  status.pressure = pressure_at(status.law, status.volume);
}

/// Sums of a sweep.
struct SweepSums {
  double net = 0.0, load = 0.0;            ///< squared [uN^2]
  double moved = 0.0;                      ///< squared [mm^2], of the balloon
  double compliance = 0.0;                 ///< [mm^3/Pa]
  double withheld = 0.0;                   ///< squared [mm^2]: of moves, by the bounds of contact
  double slack = 0.0;                      ///< the balloon's vertices that are not taut all around
  double wall_net = 0.0, wall_load = 0.0;  ///< the wall's part of net and load

  [[nodiscard]] ANGIO_HOST_DEVICE bool blocked() const { return withheld > 0.0; }
};

}  // namespace angio::simulation::detail

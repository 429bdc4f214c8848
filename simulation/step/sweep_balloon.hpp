#pragma once

#include "simulation/step/sweep_sums.hpp"

/// The step's balloon: what acts on its vertices.
namespace angio::simulation::detail {

template <class Real>
ANGIO_HOST_DEVICE inline EnergyDensity<Real> fold_energy(const StepView<Real>& s,
                                                         const CornerMetric<Real>& start,
                                                         const Vec3T<Real>& e1,
                                                         const Vec3T<Real>& e2) {
  const Invariants<Real> i = invariants(start, e1, e2);
  return plain_energy(s.balloon.folds, i.i1, i.i3);
}

/// Membrane, folds and gas on a vertex of the balloon, for the line search.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Vec3T<Real> membrane_and_gas_force(const StepView<Real>& s, int v,
                                                            const Lanes& lanes,
                                                            const Vec3T<Real>& x, Real gauge) {
  Vec3T<Real> force;
  for (int c = s.balloon.mesh.corner_begin[v] + lanes.rank();
       c < s.balloon.mesh.corner_begin[v + 1]; c += lanes.size()) {
    const Vec3T<Real> next = s.motion.x[s.balloon.mesh.corners[c].next],
                      last = s.motion.x[s.balloon.mesh.corners[c].last];
    const Vec3T<Real> e1 = x - next, e2 = last - next;
    force -= membrane_gradient(s.balloon.rest[c],
                               membrane_energy(s.balloon.law, s.balloon.rest[c], e1, e2), e1, e2);
    if (s.balloon.law.relaxed)
      force -= membrane_gradient(s.balloon.start_rest[c],
                                 fold_energy(s, s.balloon.start_rest[c], e1, e2), e1, e2);
    force += (gauge / Real(6)) * cross(e2, e1);
  }
  return sum_over(lanes, force);
}

/// Everything but the gas on a vertex of the balloon, and dV/dx of the enclosed volume [mm^2].
template <bool kSurroundings, class Real, class Lanes>
ANGIO_HOST_DEVICE inline VertexForces<Real> balloon_forces(const StepView<Real>& s, int v,
                                                           const Lanes& lanes,
                                                           Vec3T<Real>& by_volume) {
  VertexForces<Real> out;
  by_volume = {};
  const Vec3T<Real> x = s.motion.x[v];
  for (int c = s.balloon.mesh.corner_begin[v] + lanes.rank();
       c < s.balloon.mesh.corner_begin[v + 1]; c += lanes.size()) {
    const Vec3T<Real> next = s.motion.x[s.balloon.mesh.corners[c].next],
                      last = s.motion.x[s.balloon.mesh.corners[c].last];
    const Vec3T<Real> e1 = x - next, e2 = last - next;
    const EnergyDensity<Real> psi = membrane_energy(s.balloon.law, s.balloon.rest[c], e1, e2);
    const VertexTerm<Real> term = membrane_term(s.balloon.rest[c], psi, e1, e2);
    out.force -= term.gradient;
    out.hessian += term.hessian;
    out.taut = out.taut && psi.taut;
    if (s.balloon.law.relaxed) {
      const EnergyDensity<Real> fold = fold_energy(s, s.balloon.start_rest[c], e1, e2);
      if (psi.taut) {  // a thousandth of the membrane's stiffness need not be in the Hessian
        out.force -= membrane_gradient(s.balloon.start_rest[c], fold, e1, e2);
      } else {
        const VertexTerm<Real> fold_term = membrane_term(s.balloon.start_rest[c], fold, e1, e2);
        out.force -= fold_term.gradient;
        out.hessian += fold_term.hessian;
      }
    }
    // The ring of edges around the vertex is closed: any origin gives the same sum, and the vertex
    // itself the one with the least rounding.
    by_volume += (Real(1) / Real(6)) * cross(e2, e1);
  }
  if (kSurroundings && s.contact.candidates.count > 0) add_contact(s, v, lanes, out);
  gather(s, lanes, out);
  by_volume = sum_over(lanes, by_volume);
  add_inertia(s, v, out);
  return out;
}

/// The share of a balloon vertex's move to be taken, in (0, 1]: a slack membrane that goes taut
/// within the move meets it with a far greater stiffness than the Hessian it began with.
///
/// If the energy's slope along the move, positive at its end, outweighs that at its start, the
/// share is where the chord of the slope is zero. The slope is convex there, so the energy still
/// falls.
///
/// @param gauge  pressure above the outside [Pa]
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Real balloon_line_search(const StepView<Real>& s, int v,
                                                  const Lanes& lanes, Real gauge,
                                                  const Vec3T<Real>& move) {
  Real share = Real(1);
  const Real before = -dot(membrane_and_gas_force(s, v, lanes, s.motion.x[v], gauge), move);
  if (!(before < Real(0))) return share;
  for (int trial = 0; trial < 3; ++trial) {
    const Real after =
        -dot(membrane_and_gas_force(s, v, lanes, s.motion.x[v] + share * move, gauge), move);
    if (after <= -before) break;
    share *= before / (before - after);
  }
  return share;
}

/// Stiffness of the spring that leads to a prescribed volume, times the balloon's dV/dp.
inline constexpr double kVolumeSpring = 1.0;

/// A colour's moves at the present pressure, and how its volume answers to pressure.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void propose_moves(Team& team, const StepView<Real>& s, int first,
                                            int count, Real gauge, double (&total)[4]) {
  team.template quick_sum<Team::kBalloonLanes, 4>(
      count,
      [&](int i, const auto& lanes, auto* part) {
        const int v = first + i;
        Move<Real> move;
        const VertexForces<Real> f =
            balloon_forces<Team::kSurroundings>(s, v, lanes, move.by_volume);
        const Mat3T<Real> inverse = inverse_block(f.hessian);
        const Vec3T<Real> load = gauge * move.by_volume;
        const bool held = f.touching || norm_squared(f.adhesion) > Real(0);
        const Real relax = held ? Real(1) : s.balloon.relaxation;
        move.by_force = relax * (inverse * (f.force + load));
        move.by_pressure = relax * (inverse * move.by_volume);
        if (Team::kSurroundings && s.contact.candidates.count > 0) {
          move.friction = norm(inverse * f.friction);
          move.adhesion = norm(inverse * f.adhesion);
          move.contact = f.contact;
        }
        move.taut = f.taut;
        part[0] += dot(move.by_volume, move.by_force);
        part[1] += dot(move.by_volume, move.by_pressure);
        part[2] += norm_squared(f.force + load);
        part[3] += norm_squared(load) + f.contact * f.contact;
        lanes.sync();
        if (lanes.rank() == 0) s.balloon.moves[v] = move;
      },
      total);
}

/// Takes the moves with the change of pressure; total: volume gained, squared motion, what contact
/// has withheld of it, and vertices that are not taut.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void take_moves(Team& team, const StepView<Real>& s, int first, int count,
                                         Real change, Real gauge, double (&total)[4]) {
  team.template quick_sum<Team::kBalloonLanes, 4>(
      count,
      [&](int i, const auto& lanes, auto* part) {
        const int v = first + i;
        const Move<Real> move = s.balloon.moves[v];
        Vec3T<Real> by = move.by_force + change * move.by_pressure;
        if (!move.taut) by *= balloon_line_search(s, v, lanes, gauge, by);
        const Real share = bounded_share<Team>(s, v, by);
        part[2] += norm_squared((Real(1) - share) * by);
        by *= share;
        part[0] += dot(move.by_volume, by);
        part[1] += norm_squared(by);
        part[3] += move.taut ? Real(0) : Real(1);
        lanes.sync();
        if (lanes.rank() == 0) s.motion.x[v] += by;
      },
      total);
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline void sweep_balloon(Team& team, const StepView<Real>& s, StepStatus& status,
                                            SweepSums& sums) {
  GasLaw<double>& law = status.law;
  for (int color = 0; color < s.balloon.mesh.colors; ++color) {
    const int first = s.balloon.mesh.color_begin[color],
              count = s.balloon.mesh.color_begin[color + 1] - first;
    const Real p = Real(status.pressure);
    double proposed[4], taken[4];
    propose_moves(team, s, first, count, p - s.balloon.outside_pressure, proposed);
    if (law.volume > 0.0) {
      const double whole =
          status.compliance > 0.0 ? status.compliance : s.balloon.mesh.colors * proposed[1];
      law.spring = kVolumeSpring / whole;
    }
    const double least = 1e-3 * status.volume, grown = status.volume + proposed[0];
    const Real change =
        meet(converted<Real>(law), p, Real(grown > least ? grown : least), Real(proposed[1])) - p;
    take_moves(team, s, first, count, change, p + change - s.balloon.outside_pressure, taken);
    status.volume += taken[0];
    status.pressure = pressure_at(law, status.volume);
    sums.net += proposed[2];
    sums.load += proposed[3];
    sums.compliance += proposed[1];
    sums.moved += taken[1];
    sums.withheld += taken[2];
    sums.slack += taken[3];
  }
  status.compliance = sums.compliance;
  if (law.volume > 0.0) law.slope_pressure = status.pressure;
}

}  // namespace angio::simulation::detail

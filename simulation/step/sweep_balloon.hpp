#pragma once

#include "simulation/step/near_pairs.hpp"

/// The step's balloon: what acts on its vertices.
namespace angio::simulation::detail {

template <class Real>
ANGIO_HOST_DEVICE inline EnergyDensity<Real> fold_energy(const StepView<Real>& s,
                                                         const CornerMetric<Real>& start,
                                                         const Vec3T<Real>& e1,
                                                         const Vec3T<Real>& e2) {
  const Invariants<Real> i = invariants(start, e1, e2);
  return plain_energy(s.folds, i.i1, i.i3);
}

/// Skin, folds and gas on a vertex of the balloon, for the line search.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Vec3T<Real> skin_and_gas_force(const StepView<Real>& s, int v,
                                                        const Lanes& lanes, const Vec3T<Real>& x,
                                                        Real gauge) {
  Vec3T<Real> force;
  for (int c = s.corner_begin[v] + lanes.rank(); c < s.corner_begin[v + 1]; c += lanes.size()) {
    const Vec3T<Real> next = s.x[s.corners[c].next], last = s.x[s.corners[c].last];
    const Vec3T<Real> e1 = x - next, e2 = last - next;
    force -= membrane_gradient(s.rest[c], skin_energy(s.skin, s.rest[c], e1, e2), e1, e2);
    if (s.skin.relaxed)
      force -= membrane_gradient(s.start_rest[c], fold_energy(s, s.start_rest[c], e1, e2), e1, e2);
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
  const Vec3T<Real> x = s.x[v];
  for (int c = s.corner_begin[v] + lanes.rank(); c < s.corner_begin[v + 1]; c += lanes.size()) {
    const Vec3T<Real> next = s.x[s.corners[c].next], last = s.x[s.corners[c].last];
    const Vec3T<Real> e1 = x - next, e2 = last - next;
    const EnergyDensity<Real> psi = skin_energy(s.skin, s.rest[c], e1, e2);
    const VertexTerm<Real> term = membrane_term(s.rest[c], psi, e1, e2);
    out.force -= term.gradient;
    out.hessian += term.hessian;
    out.taut = out.taut && psi.taut;
    if (s.skin.relaxed) {
      const EnergyDensity<Real> fold = fold_energy(s, s.start_rest[c], e1, e2);
      if (psi.taut) {  // a thousandth of the skin's stiffness need not be in the Hessian
        out.force -= membrane_gradient(s.start_rest[c], fold, e1, e2);
      } else {
        const VertexTerm<Real> fold_term = membrane_term(s.start_rest[c], fold, e1, e2);
        out.force -= fold_term.gradient;
        out.hessian += fold_term.hessian;
      }
    }
    // The ring of edges around the vertex is closed: any origin gives the same sum, and the vertex
    // itself the one with the least rounding.
    by_volume += (Real(1) / Real(6)) * cross(e2, e1);
  }
  if (kSurroundings && s.candidate_count > 0) add_contact(s, v, lanes, out);
  gather(s, lanes, out);
  by_volume = sum_over(lanes, by_volume);
  add_inertia(s, v, out);
  return out;
}

/// The share of a balloon vertex's move to be taken, in (0, 1]: a slack skin that goes taut within
/// the move meets it with a far greater stiffness than the Hessian it began with.
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
  const Real before = -dot(skin_and_gas_force(s, v, lanes, s.x[v], gauge), move);
  if (!(before < Real(0))) return share;
  for (int trial = 0; trial < 3; ++trial) {
    const Real after = -dot(skin_and_gas_force(s, v, lanes, s.x[v] + share * move, gauge), move);
    if (after <= -before) break;
    share *= before / (before - after);
  }
  return share;
}

}  // namespace angio::simulation::detail

#pragma once

#include "simulation/step/sweep_sums.hpp"

/// The reference method within the step: its contact (contact.hpp) and its gas (gas.hpp), tet by
/// tet. All that the step knows of the method is PbdView, `begin_pbd` and `project_pbd`.
namespace angio::simulation::detail {

template <class Real>
ANGIO_HOST_DEVICE inline TetState<Real> tet_state(const StepView<Real>& s, const int* v) {
  TetState<Real> t;
  for (int i = 0; i < 4; ++i) {
    t.x[i] = s.motion.x[v[i]];
    t.before[i] = s.motion.x_before[v[i]];
    t.inverse_mass[i] = s.pbd.contact.inverse_mass[v[i]];
  }
  return t;
}

/// Takes a projection. @return how far it moves the balloon's vertices, in sum [mm]
template <class Real>
ANGIO_HOST_DEVICE inline Real take(const StepView<Real>& s, const int* v, int side_a,
                                   const AirProjection<Real>& projection, TetState<Real>& t) {
  Real moved = 0;
  for (int i = 0; i < 4 && projection.acts; ++i) {
    s.motion.x[v[i]] += projection.by[i];
    t.x[i] = s.motion.x[v[i]];
    if (i < side_a) moved += norm(projection.by[i]);
  }
  return moved;
}

/// Share of its way to the first threshold that a sweep draws a viscous tet. The paper's constraint
/// goes all of it: a bond without bound, which a deflating balloon never leaves but tears itself
/// at.
inline constexpr double kBond = 0.03;

/// A tet that has turned inside out is made flat, with friction by how far that moved its sides;
/// one of a balloon vertex and a wall triangle that has been flatter than the first threshold is
/// drawn back to it until it passes the second (the paper's viscous item).
template <class Real>
ANGIO_HOST_DEVICE inline void project_tet(const StepView<Real>& s, int index,
                                          PbdDeltas<Real>& deltas) {
  const PbdContact<Real>& paper = s.pbd.contact;
  const int* v = paper.tets + 4 * index;
  const int side_a = paper.balloon_corners[index];
  TetState<Real> t = tet_state(s, v);
  const Real volume = signed_volume(t.x);
  if (volume < Real(0)) {
    const AirProjection<Real> apart = project_volume(t, Real(0));
    take(s, v, side_a, apart, t);
    const TetGap<Real> gap = tet_gap(t.x, side_a);
    Vec3T<Real> parted;
    for (int i = 0; i < 4; ++i) parted += gap.w[i] * apart.by[i];
    const Real along = dot(parted, gap.normal);
    const AirProjection<Real> rub =
        project_friction(t, gap, s.contact.law.friction.mu_static,
                         s.contact.law.friction.mu_kinetic, along < Real(0) ? -along : along);
    deltas.friction += take(s, v, side_a, rub, t);
    deltas.touching = true;
  }
  if (side_a != 1) return;
  if (volume <= paper.volume_1) {
    paper.triggered[index] = 1;
  } else if (volume >= paper.volume_2) {
    paper.triggered[index] = 0;
  } else if (paper.triggered[index]) {
    const Real target = volume + Real(kBond) * (paper.volume_1 - volume);
    deltas.viscous += take(s, v, side_a, project_together(t, tet_gap(t.x, side_a), target), t);
  }
}

/// The paper's air mass of each tet in place of the law: all grow as the balloon's volume is to.
template <class Real>
ANGIO_HOST_DEVICE inline void begin_pbd(const StepView<Real>& s, StepStatus& status) {
  if (!s.pbd.fills_balloon()) return;
  GasLaw<double>& law = status.law;
  status.tet_growth = law.volume > 0.0 ? law.volume / s.pbd.gas.whole : 1.0;
  law.volume = 0.0;
  law.slope_pressure = double(s.balloon.outside_pressure);
}

/// The tets of the paper's gas, colour by colour.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void project_gas(Team& team, const StepView<Real>& s, double growth) {
  const PbdGas<Real>& gas = s.pbd.gas;
  for (int color = 0; color < gas.colors; ++color) {
    const int first = gas.color_begin[color];
    team.template for_each<1>(gas.color_begin[color + 1] - first, [&](int i, const auto&) {
      const int tet = first + i;
      project_gas_tet(gas, tet, Real(growth * double(gas.volume[tet])), s.motion.x);
    });
    team.barrier();
  }
}

/// The tets of the paper's contact, colour by colour.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void project_air(Team& team, const StepView<Real>& s, StepReport& report) {
  double sums[3] = {};
  for (int color = 0; color < s.pbd.contact.colors; ++color) {
    const int first = s.pbd.contact.color_begin[color];
    double total[3];
    team.template quick_sum<1, 3>(
        s.pbd.contact.color_begin[color + 1] - first,
        [&](int i, const auto&, auto* part) {
          PbdDeltas<Real> deltas;
          project_tet(s, first + i, deltas);
          part[0] += deltas.touching ? Real(1) : Real(0);
          part[1] += deltas.friction;
          part[2] += deltas.viscous;
        },
        total);
    for (int k = 0; k < 3; ++k) sums[k] += total[k];
  }
  report.contact_count = int(sums[0]);
  report.friction_delta = sums[1];
  report.viscous_delta = sums[2];
}

/// The paper's gas and contact after a sweep (gas.hpp, contact.hpp).
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void project_pbd(Team& team, const StepView<Real>& s, StepStatus& status) {
  if (!s.pbd.is_on()) return;
  team.barrier();
  if (s.pbd.gas.is_on) project_gas(team, s, status.tet_growth);
  if (s.pbd.contact.is_on) project_air(team, s, status.report);
  measure_gas(team, s, status);
}

}  // namespace angio::simulation::detail

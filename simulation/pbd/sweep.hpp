#pragma once

#include "simulation/step/views.hpp"

/// The paper's plain contact in the step: paper_contact.hpp, a tet at a time.
namespace angio::simulation::detail {

template <class Real>
ANGIO_HOST_DEVICE inline TetState<Real> tet_state(const StepView<Real>& s, const int* v) {
  TetState<Real> t;
  for (int i = 0; i < 4; ++i) {
    t.x[i] = s.x[v[i]];
    t.before[i] = s.x_before[v[i]];
    t.inverse_mass[i] = s.paper.inverse_mass[v[i]];
  }
  return t;
}

/// Takes a projection. @return how far it moves the balloon's vertices, in sum [mm]
template <class Real>
ANGIO_HOST_DEVICE inline Real take(const StepView<Real>& s, const int* v, int side_a,
                                   const AirProjection<Real>& projection, TetState<Real>& t) {
  Real moved = 0;
  for (int i = 0; i < 4 && projection.acts; ++i) {
    s.x[v[i]] += projection.by[i];
    t.x[i] = s.x[v[i]];
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
                                          PaperDeltas<Real>& deltas) {
  const PaperContact<Real>& paper = s.paper;
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
    const AirProjection<Real> rub = project_friction(
        t, gap, s.friction.mu_static, s.friction.mu_kinetic, along < Real(0) ? -along : along);
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

}  // namespace angio::simulation::detail

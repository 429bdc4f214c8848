#pragma once

#include <cmath>

#include "simulation/contact/contact_force.hpp"
#include "simulation/contact/distance.hpp"

/// The seed paper's plain contact (sections 4.2, 4.3), for comparison: positions are projected, air
/// tet by air tet, after each sweep.
///
/// Not convergent: what holds the surfaces apart is the number of projections, not a force; a
/// surface may pass through the other where no tet lies between; and the balance of forces is left
/// open by what the projections move.
namespace angio::simulation::detail {

/// What a projection does to a tet whose first vertices are of one surface.
template <class Real>
struct AirProjection {
  Vec3T<Real> by[4];  ///< moves [mm]
  bool acts = false;
};

/// What the projections need of a tet: present positions, those before the step, inverse masses.
template <class Real>
struct TetState {
  Vec3T<Real> x[4], before[4];
  Real inverse_mass[4]{};  ///< [1/g]; 0: held
};

template <class Real>
ANGIO_HOST_DEVICE inline Real signed_volume(const Vec3T<Real> (&x)[4]) {
  return dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) / Real(6);
}

/// The moves that take a tet's volume to `target` [mm^3], to first order, in the directions of its
/// gradient weighted by the inverse masses: Eq. 20 as a projection. None further than a tenth of an
/// edge.
template <class Real>
ANGIO_HOST_DEVICE inline AirProjection<Real> project_volume(const TetState<Real>& t, Real target) {
  const Vec3T<Real> b = t.x[1] - t.x[0], c = t.x[2] - t.x[0], d = t.x[3] - t.x[0];
  Vec3T<Real> slope[4] = {{}, cross(c, d) / Real(6), cross(d, b) / Real(6), cross(b, c) / Real(6)};
  slope[0] = -(slope[1] + slope[2] + slope[3]);
  Real weight = 0;
  for (int i = 0; i < 4; ++i) weight += t.inverse_mass[i] * norm_squared(slope[i]);
  AirProjection<Real> out;
  if (!(weight > Real(0))) return out;
  const Real scale = (target - dot(b, slope[1])) / weight;
  Real farthest = 0, edge = 0;
  for (int i = 0; i < 4; ++i) {
    out.by[i] = (scale * t.inverse_mass[i]) * slope[i];
    farthest = norm(out.by[i]) > farthest ? norm(out.by[i]) : farthest;
    edge = norm(t.x[i] - t.x[0]) > edge ? norm(t.x[i] - t.x[0]) : edge;
  }
  // A sliver's volume hardly answers to motion: it would be thrown away.
  const Real most = Real(0.1) * edge;
  for (int i = 0; i < 4 && farthest > most; ++i) out.by[i] *= most / farthest;
  out.acts = true;
  return out;
}

/// The relative motion that friction acts on, for a tet whose first `side_a` vertices are of one
/// surface: 1 + 3, 2 + 2 or 3 + 1.
template <class Real>
struct TetGap {
  Real w[4]{};         ///< weights of the gap: those of the first side sum to 1, all to 0
  Vec3T<Real> normal;  ///< unit; zero for a degenerate tet
};

template <class Real>
ANGIO_HOST_DEVICE inline TetGap<Real> tet_gap(const Vec3T<Real> (&x)[4], int side_a) {
  TetGap<Real> gap;
  GapWeights<Real> g;
  if (side_a == 2) {
    g = segment_segment_gap(x[0], x[1], x[2], x[3]);
    for (int i = 0; i < 4; ++i) gap.w[i] = g.w[i];
    gap.normal = cross(x[1] - x[0], x[3] - x[2]);
  } else if (side_a == 1) {
    g = point_triangle_gap(x[0], x[1], x[2], x[3]);
    for (int i = 0; i < 4; ++i) gap.w[i] = g.w[i];
    gap.normal = cross(x[2] - x[1], x[3] - x[1]);
  } else {
    g = point_triangle_gap(x[3], x[0], x[1], x[2]);
    gap.w[3] = -g.w[0];
    for (int i = 0; i < 3; ++i) gap.w[i] = -g.w[i + 1];
    gap.normal = cross(x[1] - x[0], x[2] - x[0]);
  }
  const Real length = norm(gap.normal);
  gap.normal = length > Real(0) ? gap.normal / length : Vec3T<Real>{};
  return gap;
}

/// The viscous item: vertex and triangle drawn together along the triangle's normal, shared by the
/// inverse masses, until the volume is `target` [mm^3] (the paper's section 4.3).
template <class Real>
ANGIO_HOST_DEVICE inline AirProjection<Real> project_together(const TetState<Real>& t,
                                                              const TetGap<Real>& gap,
                                                              Real target) {
  const Real volume = signed_volume(t.x);
  Real weight = 0, height = 0;
  for (int i = 0; i < 4; ++i) {
    weight += gap.w[i] * gap.w[i] * t.inverse_mass[i];
    height += gap.w[i] * dot(t.x[i] - t.x[0], gap.normal);
  }
  AirProjection<Real> out;
  if (!(weight > Real(0)) || !(volume > Real(0))) return out;
  const Real change = height * (target / volume - Real(1));
  for (int i = 0; i < 4; ++i)
    out.by[i] = (change * gap.w[i] * t.inverse_mass[i] / weight) * gap.normal;
  out.acts = true;
  return out;
}

/// Friction as a projection: Eqs. 23-27 with the errata in docs/method/simulation.md,
///
///     t = P sum_i w_i (x_i - x_before_i),  P across the normal
///     s = |t| min(1, mu d_n / |t|) / sum_i w_i^2 / m_i,   dx_i = -(w_i / m_i) s t / |t|
///
/// with mu = mu_s where that holds all of t, else mu_k, and d_n the normal correction of this step.
/// sum_i m_i dx_i = 0, as the weights sum to 0.
///
/// @param normal_correction  d_n [mm], >= 0
template <class Real>
ANGIO_HOST_DEVICE inline AirProjection<Real> project_friction(const TetState<Real>& t,
                                                              const TetGap<Real>& gap,
                                                              Real mu_static, Real mu_kinetic,
                                                              Real normal_correction) {
  Vec3T<Real> slip;
  Real weight = 0;
  for (int i = 0; i < 4; ++i) {
    slip += gap.w[i] * (t.x[i] - t.before[i]);
    weight += gap.w[i] * gap.w[i] * t.inverse_mass[i];
  }
  slip -= dot(slip, gap.normal) * gap.normal;
  const Real length = norm(slip);
  AirProjection<Real> out;
  if (!(weight > Real(0)) || !(length > Real(0))) return out;
  const Real most = mu_kinetic * normal_correction;
  const Real taken = length <= mu_static * normal_correction ? length
                     : most < length                         ? most
                                                             : length;
  for (int i = 0; i < 4; ++i)
    out.by[i] = (-gap.w[i] * t.inverse_mass[i] * taken / (weight * length)) * slip;
  out.acts = taken > Real(0);
  return out;
}

/// What the projection of a tet has done.
template <class Real>
struct PbdDeltas {
  Real friction{}, viscous{};  ///< how far it moved the balloon's vertices, in sum [mm]
  bool touching = false;       ///< it had turned inside out
};

/// The tets of the gap that touch both surfaces, and what is kept of them; balloon vertices first,
/// right-handed. Colour by colour: those of one colour share no vertex.
template <class Real>
struct PbdContact {
  bool is_on = false;
  int tet_count = 0, colors = 0;
  const int* color_begin = nullptr;      ///< first tet of a colour, [color + 1]
  const int* tets = nullptr;             ///< four vertices each
  const int* balloon_corners = nullptr;  ///< [tet] 1, 2 or 3
  const Real* inverse_mass = nullptr;    ///< [vertex] [1/g]; 0: held
  char* triggered = nullptr;             ///< [tet] its viscous item
  Real volume_1{}, volume_2{};           ///< the paper's thresholds [mm^3]
};

}  // namespace angio::simulation::detail

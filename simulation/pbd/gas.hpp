#pragma once

#include "simulation/pbd/contact.hpp"

/// The seed paper's inflation (section 5.1), for comparison: the balloon's inside as tets of a node
/// of the guidewire and a triangle, each with its own gas, P_i V_i = k Q_i, projected to P_i =
/// P_blood after each sweep.
///
/// A command for volumes, V_i = k Q_i / P_blood: where all are met nothing is left above the
/// blood's pressure, so the membrane cannot be in balance and the result depends on the number of
/// sweeps. The apex is the nearest node, so that the tets neither fill the balloon nor keep apart.
namespace angio::simulation::detail {

template <class Real>
struct PbdGas {
  bool is_on = false;
  int tet_count = 0, colors = 0;
  const int* color_begin = nullptr;    ///< first tet of a colour, [color + 1]; they share no vertex
  const Vec3T<Real>* apex = nullptr;   ///< node of the guidewire; it stays
  const int* triangles = nullptr;      ///< outward, three vertices each
  const Real* inverse_mass = nullptr;  ///< [1/g], shape [vertex]; 0: held
  const Real* volume = nullptr;        ///< at the start [mm^3], > 0
  double whole = 0.0;                  ///< that the balloon encloses then [mm^3]
};

/// The volume to which a projection of C = k Q / V - P_blood takes a tet: V + (V - V^2 / V_t).
///
/// dx = -w grad C C / sum w |grad C|^2 with grad C = -(k Q / V^2) grad V. From V = 2 V_t it would
/// go to nothing, and from above diverge: no further than to half of V. A tet that is inside out or
/// flat is opened towards a hundredth of its target.
template <class Real>
ANGIO_HOST_DEVICE inline Real pbd_gas_volume(Real volume, Real target) {
  const Real least = Real(0.01) * target;
  if (!(volume > least)) return least;
  const Real next = Real(2) * volume - volume * volume / target;
  return next > Real(0.5) * volume ? next : Real(0.5) * volume;
}

/// One projection of a tet. @param target  V_t = k Q / P_blood [mm^3], > 0
/// @param x  [mm], shape [vertex]
template <class Real>
ANGIO_HOST_DEVICE inline void project_gas_tet(const PbdGas<Real>& gas, int tet, Real target,
                                              Vec3T<Real>* x) {
  const int* v = gas.triangles + 3 * tet;
  TetState<Real> t;
  t.x[0] = gas.apex[tet];
  for (int k = 0; k < 3; ++k) {
    t.x[k + 1] = x[v[k]];
    t.inverse_mass[k + 1] = gas.inverse_mass[v[k]];
  }
  const AirProjection<Real> moved = project_volume(t, pbd_gas_volume(signed_volume(t.x), target));
  for (int k = 0; moved.acts && k < 3; ++k) x[v[k]] += moved.by[k + 1];
}

}  // namespace angio::simulation::detail

#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "core/vec3.hpp"

/// What acts between two surfaces a small gap apart: a barrier along the gap, friction across it.
namespace angio::simulation::detail {

/// A barrier's value, slope and curvature by the gap.
template <class Real>
struct Barrier {
  Real value{}, slope{}, curvature{};
};

/// b(d) = -(d - r)^2 ln(d / r) for 0 < d < r, else 0: zero with two derivatives at d = r, infinite
/// at d = 0.
///
/// Source: Li et al., "Incremental Potential Contact", ACM TOG 39 (2020), Eq. 6, on distances.
///
/// @param d  gap [mm], > 0
/// @param r  contact distance [mm], > 0
/// @return [mm^2], [mm], [1]
template <class Real>
ANGIO_HOST_DEVICE inline Barrier<Real> barrier(Real d, Real r) {
  using std::log;
  if (d >= r) return {};
  const Real l = log(d / r), g = d - r, q = g / d;
  return {-g * g * l, -g * (Real(2) * l + q), -Real(2) * l - Real(4) * q + q * q};
}

/// Stiffness [Pa/mm] with which a unit area carries `pressure` [Pa] at half the contact distance:
/// b'(r/2) = -(ln 2 + 1/2) r.
template <class Real>
ANGIO_HOST_DEVICE inline Real barrier_stiffness(Real pressure, Real contact_distance) {
  return pressure / (Real(1.1931471805599453) * contact_distance);
}

/// Friction coefficients and the slip [mm] in one step below which contact sticks.
template <class Real>
struct Friction {
  Real mu_static{}, mu_kinetic{}, stick_slip{};
};

/// Friction force per normal force and per slip, mu(y) / y: the force on side a is
/// -(mu / y) N u, with u its tangential motion relative to side b in this step and y = |u|.
///
/// mu rises smoothly to mu_static at y = stick_slip, then falls to mu_kinetic at twice that slip.
/// Source: Li et al. 2020, section 5.2 (f1, Eq. 14), with the fall added; limit mu N as the seed
/// paper's Eq. 24, errata in docs/method/simulation.md.
template <class Real>
ANGIO_HOST_DEVICE inline Real friction_per_slip(const Friction<Real>& f, Real y) {
  const Real e = f.stick_slip;
  if (y <= e) return f.mu_static * (Real(2) - y / e) / e;
  const Real kinetic = f.mu_kinetic < f.mu_static ? f.mu_kinetic : f.mu_static;
  if (y >= Real(2) * e) return kinetic / y;
  const Real s = y / e - Real(1);
  const Real blend = s * s * (Real(3) - Real(2) * s);
  return (f.mu_static + blend * (kinetic - f.mu_static)) / y;
}

}  // namespace angio::simulation::detail

#pragma once

#include "simulation/step/views.hpp"

/// What acts on one vertex, gathered by the threads (`lanes`, team.hpp) that share it.
namespace angio::simulation::detail {

template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<double> in_double(const Vec3T<Real>& v) {
  return {double(v.x), double(v.y), double(v.z)};
}

/// What a vertex's neighbours ask of it.
template <class Real>
struct VertexForces {
  Vec3T<Real> force;     // without the gas [uN]
  Mat3T<Real> hessian;   // [uN/mm]
  Vec3T<Real> friction;  // the part of `force` that is friction
  Vec3T<Real> adhesion;  // the part of `force` that is adhesion
  Vec3T<Real> own;   // the part of `force` that is a surface's contact with itself; not gathered
  Real contact{};    // sum of normal forces [uN]
  Real magnitude{};  // sum of the lengths of the forces [uN]
  bool touching = false;
  bool touching_wall = false;
  bool taut = true;  // the membrane all around
};

template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Vec3T<Real> sum_over(const Lanes& lanes, const Vec3T<Real>& v) {
  return {lanes.sum(v.x), lanes.sum(v.y), lanes.sum(v.z)};
}

template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Mat3T<Real> sum_over_symmetric(const Lanes& lanes, const Mat3T<Real>& a) {
  Mat3T<Real> b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) b(i, j) = b(j, i) = lanes.sum(a(i, j));
  return b;
}

template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline Mat3T<Real> sum_over(const Lanes& lanes, const Mat3T<Real>& a) {
  Mat3T<Real> b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) b(i, j) = lanes.sum(a(i, j));
  return b;
}

template <class Real>
ANGIO_HOST_DEVICE inline void add_inertia(const StepView<Real>& s, int v, VertexForces<Real>& out) {
  const Real k = s.motion.mass[v] / (s.motion.dt * s.motion.dt);
  out.force += k * (s.motion.x_inertial[v] - s.motion.x[v]);
  for (int i = 0; i < 3; ++i) out.hessian(i, i) += k;
}

/// Adds what the lanes have gathered. Only force and Hessian where nothing can touch.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void gather(const StepView<Real>& s, const Lanes& lanes,
                                     VertexForces<Real>& out) {
  out.force = sum_over(lanes, out.force);
  out.hessian = sum_over_symmetric(lanes, out.hessian);
  out.taut = lanes.sum(out.taut ? 0 : 1) == 0;
  if (s.contact.candidates.count == 0) return;
  out.friction = sum_over(lanes, out.friction);
  if (s.contact.wet) out.adhesion = sum_over(lanes, out.adhesion);
  out.contact = lanes.sum(out.contact);
  out.magnitude = lanes.sum(out.magnitude);
  out.touching = lanes.sum(out.touching ? 1 : 0) > 0;
}

}  // namespace angio::simulation::detail

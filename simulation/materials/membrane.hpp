#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "core/select.hpp"
#include "core/vec3.hpp"
#include "simulation/materials/membrane_law.hpp"

/// The balloon's membrane on constant-strain triangles: their invariants, energy and stress, and
/// the derivatives by their corners. The law itself is membrane_law.hpp.
namespace angio::simulation::detail {

/// The unloaded shape of a triangle seen from one corner v, with n and m the next corners:
/// e1 = x_v - x_n, e2 = x_m - x_n.
template <class Real>
struct CornerMetric {
  Real k11{}, k12{},
      k22{};           ///< K = G^-1 of the unloaded metric G = [e1.e1 e1.e2; . e2.e2] [1/mm^2]
  Real inverse_det{};  ///< 1 / det G = 1 / (4 A0^2) [1/mm^4]
  Real volume{};       ///< H A0 = h A, constant by incompressibility [mm^3]
  /// The fibres' unit direction in the unloaded triangle is f1 e1 + f2 e2 [1/mm]; 0, 0: no fibres.
  Real f1{}, f2{};
};

/// @param fibre  direction of the fibres in the unloaded shape, of any length: what lies in the
///               triangle's plane counts; zero, or normal to the plane: no fibres here
template <class Real>
ANGIO_HOST_DEVICE inline CornerMetric<Real> corner_metric(const Vec3T<Real>& v,
                                                          const Vec3T<Real>& n,
                                                          const Vec3T<Real>& m, Real thickness,
                                                          const Vec3T<Real>& fibre = {}) {
  using std::sqrt;
  const Vec3T<Real> e1 = v - n, e2 = m - n;
  const Real a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2);
  const Real det = norm_squared(cross(e1, e2));  // a c - b^2 would cancel in slivers
  CornerMetric<Real> k;
  k.inverse_det = Real(1) / det;
  k.k11 = c * k.inverse_det;
  k.k12 = -b * k.inverse_det;
  k.k22 = a * k.inverse_det;
  k.volume = thickness * Real(0.5) * sqrt(det);
  const Real p = dot(fibre, e1), q = dot(fibre, e2);
  const Real f1 = k.k11 * p + k.k12 * q, f2 = k.k12 * p + k.k22 * q;
  const Real squared = f1 * p + f2 * q;  // of the fibre's part in the plane
  if (squared > Real(1e-6) * norm_squared(fibre)) {
    k.f1 = f1 / sqrt(squared);
    k.f2 = f2 / sqrt(squared);
  }
  return k;
}

/// I1, I3 of C and the fibres' squared stretch I4 for the edges e1, e2 of the deformed triangle.
template <class Real>
struct Invariants {
  Real i1{}, i3{}, i4{};
};

template <class Real>
ANGIO_HOST_DEVICE inline Invariants<Real> invariants(const CornerMetric<Real>& k,
                                                     const Vec3T<Real>& e1, const Vec3T<Real>& e2) {
  const Real a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2);
  // a c - b^2 as a squared cross product: no cancellation in slivers.
  return {k.k11 * a + Real(2) * k.k12 * b + k.k22 * c, norm_squared(cross(e1, e2)) * k.inverse_det,
          norm_squared(k.f1 * e1 + k.f2 * e2)};
}

/// Psi of the membrane for the edges e1, e2 of the deformed triangle: base plus fibres.
///
/// With `relaxed` only the base is relaxed. The fibres' g is convex and rising in I4 = |F f|^2,
/// hence convex in F, and only pulls; so the sum stays quasiconvex and without compression, equals
/// the full energy where the base is taut, and is nowhere above the sum's own relaxation.
template <class Real>
ANGIO_HOST_DEVICE inline EnergyDensity<Real> membrane_energy(const MembraneLaw<Real>& law,
                                                             const CornerMetric<Real>& k,
                                                             const Vec3T<Real>& e1,
                                                             const Vec3T<Real>& e2) {
  const Invariants<Real> i = invariants(k, e1, e2);
  EnergyDensity<Real> e =
      law.relaxed ? relaxed_energy(law.base, i.i1, i.i3) : plain_energy(law.base, i.i1, i.i3);
  add_fibres(law.fibre, i.i4, e);
  return e;
}

/// What one term of the energy asks of one vertex: gradient [uN] and Hessian [uN/mm].
template <class Real>
struct VertexTerm {
  Vec3T<Real> gradient;
  Mat3T<Real> hessian;
};

namespace membrane {

/// The larger and smaller eigenvalue of [p q; q r] clamped at zero, put together again.
template <class Real>
struct Symmetric2 {
  Real p{}, q{}, r{};
};

template <class Real>
ANGIO_HOST_DEVICE inline Symmetric2<Real> clamp_positive(const Symmetric2<Real>& a) {
  using std::sqrt;
  const Real zero(0);
  const Real mean = Real(0.5) * (a.p + a.r), half = Real(0.5) * (a.p - a.r);
  const Real radius = sqrt(half * half + a.q * a.q);
  const Real high = mean + radius, low = mean - radius;
  // Only the projector on the larger eigenvalue is left: (A - low I) / (high - low).
  const auto is_mixed = low < zero;
  const Real s = select(high > zero, high / (high - low), zero);
  return {select(is_mixed, s * (a.p - low), a.p), select(is_mixed, s * a.q, a.q),
          select(is_mixed, s * (a.r - low), a.r)};
}

}  // namespace membrane

/// What a triangle of the membrane carries.
template <class Real>
struct MembraneStress {
  Real stretch[2]{};       ///< principal, the larger first
  Real stress[2]{};        ///< principal Cauchy stress [Pa], the larger first
  Real thickness_ratio{};  ///< h / H
  Real energy{};           ///< per unloaded volume [Pa]
};

/// Stretches, stress, thickness and energy for the edges e1, e2 of the deformed triangle.
///
///     sigma = F S F^T,   S = 2 (Psi_1 K + Psi_3 I3 C^-1 + Psi_4 f f^T),   J = 1
///
/// Its eigenvalues are those of S C, written in the edges' components. The stretches' squares are
/// those of K C.
template <class Real>
ANGIO_HOST_DEVICE inline MembraneStress<Real> membrane_stress(const MembraneLaw<Real>& law,
                                                              const CornerMetric<Real>& k,
                                                              const Vec3T<Real>& e1,
                                                              const Vec3T<Real>& e2) {
  using std::sqrt;
  const Invariants<Real> i = invariants(k, e1, e2);
  const EnergyDensity<Real> psi = membrane_energy(law, k, e1, e2);
  const Real a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2);
  const auto roots = [](Real trace, Real det, Real out[2]) {
    const Real square = trace * trace - Real(4) * det;
    const Real root = square > Real(0) ? sqrt(square) : Real(0);
    out[0] = Real(0.5) * (trace + root);
    out[1] = Real(0.5) * (trace - root);
  };
  MembraneStress<Real> out;
  roots(i.i1, i.i3, out.stretch);
  for (Real& l : out.stretch) l = sqrt(l > Real(0) ? l : Real(0));
  const Real s11 = Real(2) * (psi.d1 * k.k11 + psi.d4 * k.f1 * k.f1);
  const Real s12 = Real(2) * (psi.d1 * k.k12 + psi.d4 * k.f1 * k.f2);
  const Real s22 = Real(2) * (psi.d1 * k.k22 + psi.d4 * k.f2 * k.f2);
  const Real even = Real(2) * psi.d3 * i.i3;  // of S C: C^-1 C = I
  const Real m11 = s11 * a + s12 * b + even, m12 = s11 * b + s12 * c;
  const Real m21 = s12 * a + s22 * b, m22 = s12 * b + s22 * c + even;
  roots(m11 + m22, m11 * m22 - m12 * m21, out.stress);
  out.thickness_ratio = Real(1) / sqrt(i.i3);
  out.energy = psi.value;
  return out;
}

/// First and second derivatives of E = H A0 Psi by a = e1.e1, b = e1.e2 and c = e2.e2.
template <class Real>
struct MetricSlopes {
  Real a{}, b{}, c{};                       ///< [uN/mm]
  Real aa{}, ab{}, ac{}, bb{}, bc{}, cc{};  ///< [uN/mm^3]
};

template <class Real>
ANGIO_HOST_DEVICE inline MetricSlopes<Real> metric_slopes(const CornerMetric<Real>& k,
                                                          const EnergyDensity<Real>& psi,
                                                          const Vec3T<Real>& e1,
                                                          const Vec3T<Real>& e2) {
  const Real s = k.inverse_det, a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2);
  const Real one[3] = {k.k11, Real(2) * k.k12, k.k22};                     // of I1
  const Real three[3] = {c * s, Real(-2) * b * s, a * s};                  // of I3
  const Real four[3] = {k.f1 * k.f1, Real(2) * k.f1 * k.f2, k.f2 * k.f2};  // of I4
  Real first[3], second[3][3];
  for (int i = 0; i < 3; ++i) {
    first[i] = k.volume * (psi.d1 * one[i] + psi.d3 * three[i] + psi.d4 * four[i]);
    for (int j = i; j < 3; ++j)
      second[i][j] = k.volume * (psi.d11 * one[i] * one[j] +
                                 psi.d13 * (one[i] * three[j] + three[i] * one[j]) +
                                 psi.d33 * three[i] * three[j] + psi.d44 * four[i] * four[j]);
  }
  const Real bend = k.volume * psi.d3 * s;  // I3_ac = s, I3_bb = -2 s
  return {first[0],
          first[1],
          first[2],
          second[0][0],
          second[0][1],
          second[0][2] + bend,
          second[1][1] - Real(2) * bend,
          second[1][2],
          second[2][2]};
}

/// dE/dx_v = H A0 (2 Psi_a e1 + Psi_b e2) of E = H A0 Psi by the corner x_v, a = e1.e1, b = e1.e2.
///
/// Source: seed paper, Eqs. 15-19 with the reference volume H A0 (= h A).
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> membrane_gradient(const CornerMetric<Real>& k,
                                                       const EnergyDensity<Real>& psi,
                                                       const Vec3T<Real>& e1,
                                                       const Vec3T<Real>& e2) {
  const MetricSlopes<Real> s = metric_slopes(k, psi, e1, e2);
  return Real(2) * s.a * e1 + s.b * e2;
}

/// Gradient and Hessian block of E = H A0 Psi by the corner x_v, the Hessian's negative eigenvalues
/// set to zero.
///
///     dE/dx_v   = H A0 (2 Psi_a e1 + Psi_b e2),     a = e1.e1, b = e1.e2
///     d2E/dx_v2 = H A0 (2 Psi_a I + 4 Psi_aa e1 e1^T + 2 Psi_ab (e1 e2^T + e2 e1^T) + Psi_bb e2
///     e2^T)
///
/// Source: seed paper, Eqs. 15-19 with the reference volume H A0 (= h A). The block splits into the
/// normal direction, with the stress 2 Psi_a as its eigenvalue, and a 2 x 2 block in the plane.
/// Without branches, so that it runs on packs of triangles (core/simd.hpp).
///
/// @param e1, e2  of the deformed triangle [mm]; not parallel
template <class Real>
ANGIO_HOST_DEVICE inline VertexTerm<Real> membrane_term(const CornerMetric<Real>& k,
                                                        const EnergyDensity<Real>& psi,
                                                        const Vec3T<Real>& e1,
                                                        const Vec3T<Real>& e2) {
  const MetricSlopes<Real> s = metric_slopes(k, psi, e1, e2);
  VertexTerm<Real> term;
  term.gradient = Real(2) * s.a * e1 + s.b * e2;

  // In the plane: t1 along e2, t2 at right angles; e1 = p t1 + q t2, e2 = r t1.
  const Vec3T<Real> t1 = normalized(e2);
  const Real p = dot(e1, t1), r = dot(e2, t1);
  const Vec3T<Real> rest = e1 - p * t1;
  const Real q = norm(rest);
  // Of a triangle that is a line t2 does not matter: q = 0, and both directions across it carry
  // nothing but the stress.
  const Vec3T<Real> t2 = select(q > Real(0), Real(1) / q, Real(0)) * rest;
  const Real stress = Real(2) * s.a;
  const membrane::Symmetric2<Real> block = membrane::clamp_positive<Real>(
      {stress + Real(4) * s.aa * p * p + Real(4) * s.ab * p * r + s.bb * r * r,
       Real(4) * s.aa * p * q + Real(2) * s.ab * q * r, stress + Real(4) * s.aa * q * q});
  const Real normal = select(stress > Real(0), stress, Real(0));
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      term.hessian(i, j) = (i == j ? normal : Real(0)) + (block.p - normal) * t1[i] * t1[j] +
                           block.q * (t1[i] * t2[j] + t2[i] * t1[j]) +
                           (block.r - normal) * t2[i] * t2[j];
  return term;
}

/// Gradient and exact Hessian of a triangle's E = H A0 Psi by its edges e1 and e2.
///
///     dE/de1 = 2 E_a e1 + E_b e2,    dE/de2 = E_b e1 + 2 E_c e2
///
/// By the corners, with e1 = x_v - x_n and e2 = x_m - x_n, it is the first for x_v, the second for
/// x_m, and minus their sum for x_n.
template <class Real>
struct EdgeTerm {
  Vec3T<Real> gradient[2];
  Mat3T<Real> hessian[2][2];  ///< not clamped; [1][0] is the transpose of [0][1]
};

template <class Real>
ANGIO_HOST_DEVICE inline EdgeTerm<Real> membrane_element(const CornerMetric<Real>& k,
                                                         const EnergyDensity<Real>& psi,
                                                         const Vec3T<Real>& e1,
                                                         const Vec3T<Real>& e2) {
  const MetricSlopes<Real> s = metric_slopes(k, psi, e1, e2);
  EdgeTerm<Real> term;
  term.gradient[0] = Real(2) * s.a * e1 + s.b * e2;
  term.gradient[1] = s.b * e1 + Real(2) * s.c * e2;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Real pp = e1[i] * e1[j], pq = e1[i] * e2[j], qp = e2[i] * e1[j], qq = e2[i] * e2[j];
      const Real same = i == j ? Real(1) : Real(0);
      term.hessian[0][0](i, j) =
          Real(2) * s.a * same + Real(4) * s.aa * pp + Real(2) * s.ab * (pq + qp) + s.bb * qq;
      term.hessian[0][1](i, j) =
          s.b * same + Real(2) * s.ab * pp + Real(4) * s.ac * pq + s.bb * qp + Real(2) * s.bc * qq;
      term.hessian[1][1](i, j) =
          Real(2) * s.c * same + Real(4) * s.cc * qq + Real(2) * s.bc * (pq + qp) + s.bb * pp;
      term.hessian[1][0](j, i) = term.hessian[0][1](i, j);
    }
  return term;
}

}  // namespace angio::simulation::detail

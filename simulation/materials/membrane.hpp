#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "core/select.hpp"
#include "core/vec3.hpp"

/// The balloon's membrane: an incompressible Mooney-Rivlin membrane on constant-strain triangles,
/// written in the invariants I1, I3 of the in-plane right Cauchy-Green tensor C = F^T F, so that
/// nothing is singular where both stretches are equal (every undeformed triangle); with fibres
/// around the balloon, an energy of their squared stretch I4 = f . C f.
namespace angio::simulation::detail {

/// Mooney-Rivlin moduli [Pa].
template <class Real>
struct MooneyRivlin {
  Real c1{}, c2{};
};

/// Energy density Psi [Pa] and its derivatives by I1, I3 and I4.
template <class Real>
struct EnergyDensity {
  Real value{}, d1{}, d3{}, d11{}, d13{}, d33{};
  Real d4{}, d44{};  ///< of the fibres: they share no term with I1 and I3
  bool taut = true;  ///< tension both ways (always so for plain_energy)
};

inline constexpr int kMostFibreNodes = 32;

/// The fibres' energy g(I4) [Pa]: g' is a cubic Hermite curve through a few nodes, zero before the
/// first and straight after the last. With slope[0] = 0 the energy has a continuous Hessian; with
/// slope and curvature >= 0 it is convex in the deformation and only ever pulls. No node: no
/// fibres.
template <class Real>
struct FibreLaw {
  int count = 0;
  Real i4[kMostFibreNodes]{};         ///< increasing; the first is 1, the unloaded length
  Real value[kMostFibreNodes]{};      ///< g at the nodes [Pa]
  Real slope[kMostFibreNodes]{};      ///< g' [Pa]
  Real curvature[kMostFibreNodes]{};  ///< g'' [Pa]
};

/// What the balloon's membrane is made of.
template <class Real>
struct MembraneLaw {
  MooneyRivlin<Real> base;
  FibreLaw<Real> fibre;
  bool relaxed = false;  ///< the base carries no compression: it wrinkles (relaxed_energy)
};

/// Psi = C1 (I1 + 1/I3 - 3) + C2 (I1/I3 + I3 - 3): Mooney-Rivlin with l3 = 1 / (l1 l2).
///
/// Source: seed paper, Eqs. 8-14, with I1 = l1^2 + l2^2 and I3 = l1^2 l2^2 put in; it needs no
/// eigenvalues (the paper's Eqs. 11, 12 and 38-43 divide by zero where l1 = l2).
///
/// @param i1, i3  of C, i3 > 0
template <class Real>
ANGIO_HOST_DEVICE inline EnergyDensity<Real> plain_energy(const MooneyRivlin<Real>& m, Real i1,
                                                          Real i3) {
  const Real r = Real(1) / i3;
  EnergyDensity<Real> e;
  e.value = m.c1 * (i1 + r - Real(3)) + m.c2 * (i1 * r + i3 - Real(3));
  e.d1 = m.c1 + m.c2 * r;
  e.d3 = m.c2 - (m.c1 + m.c2 * i1) * r * r;
  e.d13 = -m.c2 * r * r;
  e.d33 = Real(2) * (m.c1 + m.c2 * i1) * r * r * r;
  return e;
}

/// The relaxed (tension-field) energy of the same membrane, which carries no compression: it
/// wrinkles.
///
///     taut      l2 >= l1^-1/2            Psi(l1, l2)
///     wrinkled  l2 <  l1^-1/2, l1 > 1    Psi(l1, l1^-1/2), the energy of uniaxial tension
///     slack     l1 <= 1                  0
///
/// l1^-1/2 is the natural width of an incompressible isotropic solid under uniaxial tension, so
/// that the three pieces meet with equal value and slope. Source: Pipkin, IMA J. Appl. Math. 36
/// (1986) 85; Steigmann, Proc. R. Soc. A 429 (1990) 141.
template <class Real>
ANGIO_HOST_DEVICE inline EnergyDensity<Real> relaxed_energy(const MooneyRivlin<Real>& m, Real i1,
                                                            Real i3) {
  using std::sqrt;
  const Real discriminant = i1 * i1 - Real(4) * i3;
  const Real d = discriminant > Real(0) ? sqrt(discriminant) : Real(0);
  const Real large = Real(0.5) * (i1 + d);  // l1^2
  EnergyDensity<Real> e;
  e.taut = false;
  if (large <= Real(1)) return e;
  const Real small = i3 / large;  // l2^2
  const Real root = sqrt(large);  // l1
  if (small * root >= Real(1)) return plain_energy(m, i1, i3);
  const Real s = Real(1) / (large * root);  // l1^-3
  e.value = m.c1 * (large + Real(2) / root - Real(3)) +
            m.c2 * (Real(1) / large + Real(2) * root - Real(3));
  const Real slope = m.c1 * (Real(1) - s) + m.c2 * (Real(1) / root - Real(1) / (large * large));
  const Real curvature =
      m.c1 * Real(1.5) * s / large + m.c2 * (Real(2) / (large * large * large) - Real(0.5) * s);
  const Real q = Real(1) / d;                                 // d > 0: here l2 < 1 < l1
  const Real by1 = Real(0.5) * (Real(1) + i1 * q), by3 = -q;  // of l1^2
  e.d1 = slope * by1;
  e.d3 = slope * by3;
  e.d11 = curvature * by1 * by1 - slope * Real(2) * i3 * q * q * q;
  e.d13 = curvature * by1 * by3 + slope * i1 * q * q * q;
  e.d33 = curvature * by3 * by3 - slope * Real(2) * q * q * q;
  return e;
}

/// Adds g(I4), g' and g'' of the fibres to an energy density.
template <class Real>
ANGIO_HOST_DEVICE inline void add_fibres(const FibreLaw<Real>& law, Real i4,
                                         EnergyDensity<Real>& e) {
  if (law.count < 1 || !(i4 > law.i4[0])) return;
  int low = 0, high = law.count;  // the node at or before i4, by bisection
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (law.i4[middle] <= i4 ? low : high) = middle;
  }
  const Real u = i4 - law.i4[low], s0 = law.slope[low], c0 = law.curvature[low];
  // g' = s0 + c0 u + q u^2 + r u^3
  Real q{}, r{};
  if (low + 1 < law.count) {
    const Real h = law.i4[low + 1] - law.i4[low], rise = (law.slope[low + 1] - s0) / h;
    const Real c1 = law.curvature[low + 1];
    q = (Real(3) * rise - Real(2) * c0 - c1) / h;
    r = (c0 + c1 - Real(2) * rise) / (h * h);
  }
  e.value +=
      law.value[low] + u * (s0 + u * (Real(0.5) * c0 + u * (q / Real(3) + u * Real(0.25) * r)));
  e.d4 += s0 + u * (c0 + u * (q + u * r));
  e.d44 += c0 + u * (Real(2) * q + u * Real(3) * r);
}

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

#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "core/vec3.hpp"

/// The balloon's skin: an incompressible Mooney-Rivlin membrane on constant-strain triangles,
/// written in the invariants I1, I3 of the in-plane right Cauchy-Green tensor C = F^T F, so that
/// nothing is singular where both stretches are equal (every undeformed triangle).
namespace angio::simulation::detail {

/// Mooney-Rivlin moduli [Pa].
template <class Real>
struct MooneyRivlin {
  Real c1{}, c2{};
};

/// Energy density Psi [Pa] and its derivatives by I1 and I3.
template <class Real>
struct EnergyDensity {
  Real value{}, d1{}, d3{}, d11{}, d13{}, d33{};
  bool taut = true;  ///< tension both ways (always so for plain_energy)
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

/// The relaxed (tension-field) energy of the same skin, which carries no compression: it wrinkles.
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

/// The unloaded shape of a triangle seen from one corner v, with n and m the next corners:
/// e1 = x_v - x_n, e2 = x_m - x_n.
template <class Real>
struct CornerMetric {
  Real k11{}, k12{},
      k22{};           ///< K = G^-1 of the unloaded metric G = [e1.e1 e1.e2; . e2.e2] [1/mm^2]
  Real inverse_det{};  ///< 1 / det G = 1 / (4 A0^2) [1/mm^4]
  Real volume{};       ///< H A0 = h A, constant by incompressibility [mm^3]
};

template <class Real>
ANGIO_HOST_DEVICE inline CornerMetric<Real> corner_metric(const Vec3T<Real>& v,
                                                          const Vec3T<Real>& n,
                                                          const Vec3T<Real>& m, Real thickness) {
  using std::sqrt;
  const Vec3T<Real> e1 = v - n, e2 = m - n;
  const Real a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2);
  const Real det = a * c - b * b;
  CornerMetric<Real> k;
  k.inverse_det = Real(1) / det;
  k.k11 = c * k.inverse_det;
  k.k12 = -b * k.inverse_det;
  k.k22 = a * k.inverse_det;
  k.volume = thickness * Real(0.5) * sqrt(det);
  return k;
}

/// I1 and I3 of C for the edges e1, e2 of the deformed triangle.
template <class Real>
struct Invariants {
  Real i1{}, i3{};
};

template <class Real>
ANGIO_HOST_DEVICE inline Invariants<Real> invariants(const CornerMetric<Real>& k,
                                                     const Vec3T<Real>& e1, const Vec3T<Real>& e2) {
  const Real a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2);
  // a c - b^2 as a squared cross product: no cancellation in slivers.
  return {k.k11 * a + Real(2) * k.k12 * b + k.k22 * c, norm_squared(cross(e1, e2)) * k.inverse_det};
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
  const Real mean = Real(0.5) * (a.p + a.r), half = Real(0.5) * (a.p - a.r);
  const Real radius = sqrt(half * half + a.q * a.q);
  const Real high = mean + radius, low = mean - radius;
  if (low >= Real(0)) return a;
  if (high <= Real(0)) return {};
  // Only the projector on the larger eigenvalue is left: (A - low I) / (high - low).
  const Real s = high / (high - low);
  return {s * (a.p - low), s * a.q, s * (a.r - low)};
}

}  // namespace membrane

/// dE/dx_v = H A0 (2 Psi_a e1 + Psi_b e2) of E = H A0 Psi by the corner x_v, a = e1.e1, b = e1.e2.
///
/// Source: seed paper, Eqs. 15-19 with the reference volume H A0 (= h A).
template <class Real>
ANGIO_HOST_DEVICE inline Vec3T<Real> membrane_gradient(const CornerMetric<Real>& k,
                                                       const EnergyDensity<Real>& psi,
                                                       const Vec3T<Real>& e1,
                                                       const Vec3T<Real>& e2) {
  const Real b = dot(e1, e2), c = dot(e2, e2);
  const Real by_a = k.volume * (psi.d1 * k.k11 + psi.d3 * c * k.inverse_det);
  const Real by_b = k.volume * Real(2) * (psi.d1 * k.k12 - psi.d3 * b * k.inverse_det);
  return Real(2) * by_a * e1 + by_b * e2;
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
///
/// @param e1, e2  of the deformed triangle [mm]; not parallel
template <class Real>
ANGIO_HOST_DEVICE inline VertexTerm<Real> membrane_term(const CornerMetric<Real>& k,
                                                        const EnergyDensity<Real>& psi,
                                                        const Vec3T<Real>& e1,
                                                        const Vec3T<Real>& e2) {
  const Real s = k.inverse_det, b = dot(e1, e2), c = dot(e2, e2);
  const Real i1a = k.k11, i1b = Real(2) * k.k12, i3a = c * s, i3b = Real(-2) * b * s;
  const Real by_a = k.volume * (psi.d1 * i1a + psi.d3 * i3a);
  const Real by_b = k.volume * (psi.d1 * i1b + psi.d3 * i3b);
  const Real aa =
      k.volume * (psi.d11 * i1a * i1a + Real(2) * psi.d13 * i1a * i3a + psi.d33 * i3a * i3a);
  const Real ab =
      k.volume * (psi.d11 * i1a * i1b + psi.d13 * (i1a * i3b + i1b * i3a) + psi.d33 * i3a * i3b);
  const Real bb = k.volume * (psi.d11 * i1b * i1b + Real(2) * psi.d13 * i1b * i3b +
                              psi.d33 * i3b * i3b - Real(2) * s * psi.d3);
  VertexTerm<Real> term;
  term.gradient = Real(2) * by_a * e1 + by_b * e2;

  // In the plane: t1 along e2, t2 at right angles; e1 = p t1 + q t2, e2 = r t1.
  const Vec3T<Real> t1 = normalized(e2);
  const Real p = dot(e1, t1), r = dot(e2, t1);
  const Vec3T<Real> rest = e1 - p * t1;
  const Real q = norm(rest);
  const Vec3T<Real> t2 = q > Real(0) ? rest / q : any_perpendicular(t1);
  const Real stress = Real(2) * by_a;
  const membrane::Symmetric2<Real> block = membrane::clamp_positive<Real>(
      {stress + Real(4) * aa * p * p + Real(4) * ab * p * r + bb * r * r,
       Real(4) * aa * p * q + Real(2) * ab * q * r, stress + Real(4) * aa * q * q});
  const Real normal = stress > Real(0) ? stress : Real(0);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      term.hessian(i, j) = (i == j ? normal : Real(0)) + (block.p - normal) * t1[i] * t1[j] +
                           block.q * (t1[i] * t2[j] + t2[i] * t1[j]) +
                           (block.r - normal) * t2[i] * t2[j];
  return term;
}

}  // namespace angio::simulation::detail

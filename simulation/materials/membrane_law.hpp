#pragma once

#include <cmath>

#include "core/host_device.hpp"

/// The law of the balloon's membrane: an incompressible Mooney-Rivlin membrane, written in the
/// invariants I1, I3 of the in-plane right Cauchy-Green tensor C = F^T F, so that nothing is
/// singular where both stretches are equal (every undeformed triangle); with fibres around the
/// balloon, an energy of their squared stretch I4 = f . C f.
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

}  // namespace angio::simulation::detail

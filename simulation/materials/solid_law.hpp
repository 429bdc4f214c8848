#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "core/vec3.hpp"

/// The wall's solid at a point: a nearly incompressible matrix with two families of fibres.
namespace angio::simulation::detail {

/// Moduli of one region [Pa]; see WallRegionMaterial.
template <class Real>
struct SolidLaw {
  Real shear{};  ///< G
  Real bulk{};   ///< K
  Real k1{};     ///< of each family; 0: no fibres
  Real k2{};
  Real share{1};  ///< rho
  Real yield{};   ///< von Mises stress; 0: never yields
  Real creep{};   ///< [1/s]; 0: at once
};

/// Energy and stress at a point, without the volumetric part. Where F is inside out the law has no
/// value: it is then infinite and `valid` false.
template <class Real>
struct SolidStress {
  Real value{};   ///< Psi [Pa]
  Mat3T<Real> p;  ///< first Piola-Kirchhoff stress, its derivative by F [Pa]
  bool valid = true;
};

/// Derivatives of the energy by I1' and I4 of both families, and what else dP/dF is made of.
template <class Real>
struct SolidTangent {
  Real d1{}, d11{};                  ///< by I1'
  Real pressed{}, pressed2{};        ///< J B', J^2 B'' of the barrier
  Real d4[2]{}, d14[2]{}, d44[2]{};  ///< by I4_i (and I1')
  Real i1{};                         ///< tr F^T F
  Real scale{};                      ///< J^(-2/3)
  Mat3T<Real> f;                     ///< F
  Mat3T<Real> t;                     ///< F^-T
  Mat3T<Real> dev;                   ///< dI1'/dF = 2 J^(-2/3) (F - I1/3 F^-T)
  Vec3T<Real> fiber[2];              ///< in the unloaded shape, unit
  Vec3T<Real> pushed[2];             ///< F a
};

/// exp(Q) and its derivatives; from Q = 8 on (a stress of a thousand times k1, beyond any tissue)
/// its parabola: neither precision overflows, and a sweep that has gone too far finds back.
template <class Real>
struct Stiffening {
  Real value{}, d1{}, d2{};
};

template <class Real>
ANGIO_HOST_DEVICE inline Stiffening<Real> stiffening(Real q) {
  using std::exp;
  constexpr Real kLast = Real(8);
  if (q <= kLast) {
    const Real e = exp(q);
    return {e, e, e};
  }
  const Real e = exp(kLast), over = q - kLast;
  return {e * (Real(1) + over + Real(0.5) * over * over), e * (Real(1) + over), e};
}

/// U(J) = K/2 ((J^2 - 1)/2 - ln J) and its derivatives [Pa]: infinite resistance to J -> 0.
///
/// Source: Simo, Taylor, Comput. Methods Appl. Mech. Eng. 85 (1991) 273.
template <class Real>
struct VolumeEnergy {
  Real value{}, d1{}, d2{};
};

template <class Real>
ANGIO_HOST_DEVICE inline VolumeEnergy<Real> volume_energy(Real bulk, Real j) {
  using std::log1p;
  if (!(j > Real(0))) return {Real(INFINITY), Real(0), Real(0)};
  const Real d = j - Real(1);  // small: formed first, so that its digits are kept
  return {Real(0.5) * bulk * (d + Real(0.5) * d * d - log1p(d)),
          Real(0.5) * bulk * d * (Real(1) + Real(1) / j),
          Real(0.5) * bulk * (Real(1) + Real(1) / (j * j))};
}

/// A point's volume below which its barrier acts.
inline constexpr double kPressed = 0.7;

/// Keeps a point from being pressed to nothing.
///
///     B(J) = -K (J - J0)^2 ln(J / J0),  J < J0;  0 from J0 on;  J0 = kPressed
///
/// The bulk modulus sees a patch's mean dilatation alone (solid.hpp), and a matrix that yields
/// holds a single point by no more than its yield stress: at the shoulder of a severe, short throat
/// a point is pressed to nothing beside others that swell. The tissue does not: it keeps its volume
/// at every point. The barrier has no part in the moderate strains by which a mesh locks, and
/// vanishes as the mesh is refined.
///
/// Source of its form, twice differentiable at J0: Li, Ferguson, Schneider, Langlois, Zorin,
/// Panozzo, Jiang, Kaufman, "Incremental Potential Contact", ACM TOG 39 (2020), Eq. 6.
///
/// @return [Pa]; infinite for J <= 0
template <class Real>
ANGIO_HOST_DEVICE inline VolumeEnergy<Real> pressed_energy(Real bulk, Real j) {
  using std::log;
  const Real limit = Real(kPressed);
  if (!(j > Real(0))) return {Real(INFINITY), Real(0), Real(0)};
  if (!(j < limit)) return {};
  const Real over = j - limit, l = log(j / limit), share = over / j;
  return {-bulk * over * over * l, -bulk * over * (Real(2) * l + share),
          -bulk * (Real(2) * l + Real(4) * share - share * share)};
}

/// Q of a family of fibres, by I1' - 3 and <I4 - 1>.
template <class Real>
ANGIO_HOST_DEVICE inline Real stiffening_exponent(const SolidLaw<Real>& law, Real i1, Real taut) {
  return law.k2 * ((Real(1) - law.share) * i1 * i1 + law.share * taut * taut);
}

/// The greater Q of both families at a deformation gradient; 0 without fibres.
template <class Real>
ANGIO_HOST_DEVICE inline Real greatest_exponent(const SolidLaw<Real>& law, const Vec3T<Real>* fiber,
                                                const Mat3T<Real>& f) {
  using std::cbrt;
  if (!(law.k1 > Real(0))) return Real(0);
  Real squares = 0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) squares += f(a, b) * f(a, b);
  const Real root = cbrt(determinant(f)), i1 = squares / (root * root) - Real(3);
  Real most = 0;
  for (int i = 0; i < 2; ++i) {
    const Real over = norm_squared(f * fiber[i]) - Real(1);
    const Real q = stiffening_exponent(law, i1, over > Real(0) ? over : Real(0));
    most = q > most ? q : most;
  }
  return most;
}

/// Energy and stress of a deformation gradient, without the patch's volumetric part, and what the
/// tangent needs.
///
///     Psi = G/2 (I1' - 3) + sum_i k1 / (2 k2) (exp(Q_i) - 1) + B(J)
///     Q_i = k2 [(1 - rho) (I1' - 3)^2 + rho <I4_i - 1>^2]
///     P   = Psi_1 dI1'/dF + sum_i 2 Psi_4i (F a_i) a_i^T + J B' F^-T
///
/// Source: Holzapfel, Gasser, Ogden, J. Elasticity 61 (2000), Eqs. 63-66 (rho = 1), and Holzapfel,
/// Sommer, Gasser, Regitnig, Am. J. Physiol. 289 (2005) H2048 (rho < 1; mu = G/2; the sum over both
/// families). Departures: I4 is that of F, not of its volume-preserving part, for which the stress
/// of a fibre would act across it (Nolan, Gower, Destrade, Ogden, McGarry, J. Mech. Behav. Biomed.
/// Mater. 39 (2014) 48); and a slack fibre drops the term of I4 alone, so that Psi and P have no
/// step at I4 = 1 for rho < 1 either.
///
/// @param fiber  a_0, a_1, unit
template <class Real>
ANGIO_HOST_DEVICE inline SolidStress<Real> solid_stress(const SolidLaw<Real>& law,
                                                        const Vec3T<Real>* fiber,
                                                        const Mat3T<Real>& f,
                                                        SolidTangent<Real>& tangent) {
  using std::cbrt;
  SolidStress<Real> out;
  const Real j = determinant(f);
  if (!(j > Real(0))) {
    out.valid = false;
    out.value = Real(INFINITY);
    return out;
  }
  SolidTangent<Real>& k = tangent;
  k.f = f;
  k.t = transpose(inverse(f));
  const Real root = Real(1) / cbrt(j);
  k.scale = root * root;
  k.i1 = Real(0);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) k.i1 += f(a, b) * f(a, b);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      k.dev(a, b) = Real(2) * k.scale * (f(a, b) - k.i1 / Real(3) * k.t(a, b));
  const Real i1 = k.scale * k.i1 - Real(3);
  k.d1 = Real(0.5) * law.shear;
  k.d11 = Real(0);
  out.value = k.d1 * i1;
  for (int i = 0; i < 2; ++i) {
    k.d4[i] = k.d14[i] = k.d44[i] = Real(0);
    if (!(law.k1 > Real(0))) continue;
    k.fiber[i] = fiber[i];
    k.pushed[i] = f * fiber[i];
    const Real over = norm_squared(k.pushed[i]) - Real(1);
    const Real taut = over > Real(0) ? over : Real(0);
    const Real round = Real(1) - law.share;
    const Stiffening<Real> e = stiffening(stiffening_exponent(law, i1, taut));
    const Real q1 = Real(2) * law.k2 * round * i1, q4 = Real(2) * law.k2 * law.share * taut;
    const Real half = law.k1 / (Real(2) * law.k2);
    out.value += half * (e.value - Real(1));
    k.d1 += half * e.d1 * q1;
    k.d11 += half * (e.d2 * q1 * q1 + e.d1 * Real(2) * law.k2 * round);
    k.d4[i] = half * e.d1 * q4;
    k.d14[i] = half * e.d2 * q1 * q4;
    k.d44[i] =
        half * (e.d2 * q4 * q4 + (over > Real(0) ? e.d1 * Real(2) * law.k2 * law.share : Real(0)));
  }
  const VolumeEnergy<Real> barrier = pressed_energy(law.bulk, j);
  out.value += barrier.value;
  k.pressed = j * barrier.d1;
  k.pressed2 = j * j * barrier.d2;
  out.p = k.d1 * k.dev + k.pressed * k.t;
  for (int i = 0; i < 2; ++i)
    if (k.d4[i] > Real(0)) out.p += (Real(2) * k.d4[i]) * outer(k.pushed[i], k.fiber[i]);
  return out;
}

/// How steeply the stress rises where it rises most, within a factor of two: half of the largest
/// eigenvalue of d2 Psi / dF2, the sum of its terms' largest ones, without the barrier [Pa].
template <class Real>
ANGIO_HOST_DEVICE inline Real solid_stiffness(const SolidTangent<Real>& k) {
  Real dev = 0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) dev += k.dev(a, b) * k.dev(a, b);
  Real stiffness = k.scale * k.d1 + Real(0.5) * k.d11 * dev;
  for (int i = 0; i < 2; ++i)
    if (k.d4[i] > Real(0)) stiffness += k.d4[i] + Real(2) * k.d44[i] * norm_squared(k.pushed[i]);
  return stiffness;
}

/// A corner's gradient as the tangent sees it: F g, F^-T g, (dI1'/dF) g, a_i . g.
template <class Real>
struct SeenGradient {
  Vec3T<Real> g, f, t, dev;
  Real along[2]{};
};

template <class Real>
ANGIO_HOST_DEVICE inline SeenGradient<Real> seen_gradient(const SolidTangent<Real>& k,
                                                          const Vec3T<Real>& g) {
  SeenGradient<Real> s{g, k.f * g, k.t * g, k.dev * g, {}};
  for (int i = 0; i < 2; ++i)
    s.along[i] = k.d4[i] > Real(0) || k.d44[i] > Real(0) ? dot(k.fiber[i], g) : Real(0);
  return s;
}

/// The block H_ik = sum_JL d2 Psi / dF_iJ dF_kL g_J h_L: what the corners with gradients g and h
/// ask of each other at this point [Pa/mm^2]. With T = F^-T, u = F g, v = F h, p = T g, q = T h:
///
///     d2 I1'/dF2 : (g, h)
///         = 2 J^(-2/3) [(g.h) I - 2/3 (p v^T + u q^T) + I1 (2/9 p q^T + 1/3 q p^T)]
///     d2 I4_i/dF2 : (g, h) = 2 (a_i.g) (a_i.h) I
///     d2 B/dF2 : (g, h) = J^2 B'' p q^T + J B' (p q^T - q p^T)
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> solid_block(const SolidTangent<Real>& k,
                                                 const SeenGradient<Real>& g,
                                                 const SeenGradient<Real>& h) {
  const Real s = Real(2) * k.scale * k.d1;
  Real diagonal = s * dot(g.g, h.g);
  // Rows of the outer products with v, q and p, gathered so that each entry takes few products.
  const Vec3T<Real> by_v = (Real(-2) / Real(3) * s) * g.t;
  const Vec3T<Real> by_q = s * (Real(-2) / Real(3) * g.f + Real(2) / Real(9) * k.i1 * g.t) +
                           (k.pressed2 + k.pressed) * g.t;
  const Vec3T<Real> by_p = (s * k.i1 / Real(3) - k.pressed) * h.t;
  Vec3T<Real> by_dev = k.d11 * g.dev, by_pushed[2];
  for (int i = 0; i < 2; ++i) {
    diagonal += Real(2) * k.d4[i] * g.along[i] * h.along[i];
    by_dev += (Real(2) * k.d14[i] * g.along[i]) * k.pushed[i];
    by_pushed[i] = (Real(2) * k.d14[i] * h.along[i]) * g.dev +
                   (Real(4) * k.d44[i] * g.along[i] * h.along[i]) * k.pushed[i];
  }
  Mat3T<Real> out;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      out(a, b) = by_v[a] * h.f[b] + by_q[a] * h.t[b] + by_p[a] * g.t[b] + by_dev[a] * h.dev[b] +
                  by_pushed[0][a] * k.pushed[0][b] + by_pushed[1][a] * k.pushed[1][b] +
                  (a == b ? diagonal : Real(0));
  return out;
}

}  // namespace angio::simulation::detail

#pragma once

#include <cmath>
#include <limits>

#include "core/host_device.hpp"
#include "core/vec3.hpp"

/// The wall's law: shape matching with plastic flow. Mueller, Heidelberger, Teschner, Gross,
/// "Meshless Deformations Based on Shape Matching", ACM TOG 24 (2005), sections 3.3 to 4.4.
namespace angio::simulation::detail {

template <class Real>
inline constexpr Real kTiny = std::numeric_limits<Real>::min();
template <class Real>
inline constexpr Real kEpsilon = std::numeric_limits<Real>::epsilon();

/// The rotation nearest to A (the polar decomposition's R), starting from a guess.
///
///     R <- exp(omega) R,   omega = sum_j r_j x a_j / (|sum_j r_j . a_j| + eps)
///
/// Source: Mueller, Bender, Chentanez, Macklin, "A Robust Method to Extract the Rotational Part of
/// Deformations", MIG 2016, Eq. 10. Flat or mirrored A still gives a proper rotation.
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> nearest_rotation(const Mat3T<Real>& a, Mat3T<Real> rotation,
                                                      int iterations = 20) {
  using std::abs;
  using std::cos;
  using std::sin;
  for (int step = 0; step < iterations; ++step) {
    Vec3T<Real> omega;
    Real trace = 0;
    Real scale = 0;
    for (int j = 0; j < 3; ++j) {
      const Vec3T<Real> r{rotation(0, j), rotation(1, j), rotation(2, j)};
      const Vec3T<Real> c{a(0, j), a(1, j), a(2, j)};
      omega += cross(r, c);
      trace += dot(r, c);
      scale += norm(c);
    }
    omega *= Real(1) / (abs(trace) + Real(1e-9) * scale + kTiny<Real>);
    const Real angle = norm(omega);
    if (angle < Real(4) * kEpsilon<Real>) break;
    const Vec3T<Real> u = omega / angle;
    const Real c = cos(angle), s = sin(angle);
    Mat3T<Real> turn;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) turn(i, j) = (Real(1) - c) * u[i] * u[j] + (i == j ? c : Real(0));
    turn(0, 1) -= s * u.z;
    turn(1, 0) += s * u.z;
    turn(0, 2) += s * u.y;
    turn(2, 0) -= s * u.y;
    turn(1, 2) -= s * u.x;
    turn(2, 1) += s * u.x;
    rotation = turn * rotation;
  }
  return rotation;
}

/// The eigenvalue of greatest magnitude of a symmetric matrix: the 2-norm that c_yield bounds.
///
/// Closed form by the trigonometric solution of the characteristic polynomial.
template <class Real>
ANGIO_HOST_DEVICE inline Real spectral_norm(const Mat3T<Real>& s) {
  using std::abs;
  using std::acos;
  using std::cos;
  using std::sqrt;
  const Real mean = (s(0, 0) + s(1, 1) + s(2, 2)) / Real(3);
  Real spread = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Real d = s(i, j) - (i == j ? mean : Real(0));
      spread += d * d;
    }
  spread = sqrt(spread / Real(6));
  if (spread <= Real(4) * kEpsilon<Real> * (abs(mean) + kTiny<Real>)) return abs(mean);
  Mat3T<Real> b = s;
  for (int i = 0; i < 3; ++i) b(i, i) -= mean;
  Real half = determinant((Real(1) / spread) * b) / Real(2);
  half = half < Real(-1) ? Real(-1) : (half > Real(1) ? Real(1) : half);
  const Real angle = acos(half) / Real(3);
  const Real high = mean + Real(2) * spread * cos(angle);
  const Real low = mean + Real(2) * spread * cos(angle + Real(2.0943951023931953));
  return abs(high) > abs(low) ? abs(high) : abs(low);
}

/// Mueller 2005, section 4.4.
template <class Real>
struct PlasticFlow {
  Real yield{};  ///< c_yield [1]
  Real creep{};  ///< c_creep [1/s]
  Real max{};    ///< c_max [1]
};

/// One step of plastic flow of a cluster: the new S^p.
///
///     |S - I|_2 > c_yield:   S^p <- [I + (1 - exp(-dt c_creep)) (S - I)] S^p
///     |S^p - I|_2 > c_max:   S^p <- I + c_max (S^p - I) / |S^p - I|_2
///
/// Source: Mueller 2005, section 4.4, with two departures. (1) The paper divides S^p by det^(1/3)
/// to keep a solid's volume; a slab of vessel wall is a hollow ring whose lumen may grow while the
/// tissue thins, and the division would shorten a widened slab along the vessel and tear it from
/// its neighbours: left out. (2) 1 - exp(-dt c) in place of dt c: the same to first order, and it
/// cannot overshoot at long steps.
///
/// @param stretch  S, the symmetric part of the cluster's best linear map, relative to S^p
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> flow(const PlasticFlow<Real>& law, const Mat3T<Real>& stretch,
                                          const Mat3T<Real>& plastic, Real dt) {
  using std::exp;
  Mat3T<Real> strain = stretch;
  for (int i = 0; i < 3; ++i) strain(i, i) -= Real(1);
  if (!(spectral_norm(strain) > law.yield)) return plastic;
  Mat3T<Real> next = (Real(1) - exp(-dt * law.creep)) * strain;
  for (int i = 0; i < 3; ++i) next(i, i) += Real(1);
  next = next * plastic;
  // S S^p is not symmetric where their axes differ; its symmetric part keeps a pure stretch.
  next = Real(0.5) * (next + transpose(next));
  for (int i = 0; i < 3; ++i) next(i, i) -= Real(1);
  const Real size = spectral_norm(next);
  if (size > law.max) next = (law.max / size) * next;
  for (int i = 0; i < 3; ++i) next(i, i) += Real(1);
  return next;
}

}  // namespace angio::simulation::detail

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

/// Functions of a slab's members beside x, y, z: shape_modes.hpp.
inline constexpr int kShapeModes = 6;

/// A map of a slab's shape: q -> linear q + sum_k modes_k phi_k.
template <class Real>
struct ShapeMap {
  Mat3T<Real> linear = Mat3T<Real>::identity();
  Vec3T<Real> modes[kShapeModes];
};

/// How far a map is from the identity: |(linear - I, modes)|_2, the greatest singular value of the
/// 3 x 9 matrix. Of a symmetric linear map alone it is Mueller's |S - I|_2.
template <class Real>
ANGIO_HOST_DEVICE inline Real strain_size(const ShapeMap<Real>& map) {
  using std::sqrt;
  Mat3T<Real> strain = map.linear;
  for (int i = 0; i < 3; ++i) strain(i, i) -= Real(1);
  Mat3T<Real> uneven;
  for (const Vec3T<Real>& mode : map.modes) uneven += outer(mode, mode);
  if (!(uneven(0, 0) + uneven(1, 1) + uneven(2, 2) > Real(0))) return spectral_norm(strain);
  return sqrt(spectral_norm(strain * transpose(strain) + uneven));
}

/// One step of plastic flow of a slab: the new plastic map (S^p, N^p).
///
///     |(S - I, E)|_2 > c_yield:      S^p <- [I + (1 - exp(-dt c_creep)) (S - I)] S^p
///                                    N^p <- N^p + (1 - exp(-dt c_creep)) E
///     |(S^p - I, N^p)|_2 > c_max:    (S^p - I, N^p) <- c_max (S^p - I, N^p) / |(S^p - I, N^p)|_2
///
/// Source: Mueller 2005, section 4.4, which has no N^p; where S and S^p have the same axes the
/// first line is S^p + (1 - exp(-dt c)) (S S^p - S^p), and the second is its like. Two departures.
/// (1) The paper divides S^p by det^(1/3)
/// to keep a solid's volume; a slab of vessel wall is a hollow ring whose lumen may grow while the
/// tissue thins, and the division would shorten a widened slab along the vessel and tear it from
/// its neighbours: left out. (2) 1 - exp(-dt c) in place of dt c: the same to first order, and it
/// cannot overshoot at long steps. A stretch l held for a time T above yield so leaves
/// S^p = l - (l - 1) exp(-T c), whatever the step.
///
/// @param elastic  S, the symmetric part of the slab's best linear map, relative to S^p; E, the
///                 best coefficients of the modes less N^p
template <class Real>
ANGIO_HOST_DEVICE inline ShapeMap<Real> flow(const PlasticFlow<Real>& law,
                                             const ShapeMap<Real>& elastic,
                                             const ShapeMap<Real>& plastic, Real dt) {
  using std::exp;
  if (!(strain_size(elastic) > law.yield)) return plastic;
  const Real share = Real(1) - exp(-dt * law.creep);
  ShapeMap<Real> next = plastic;
  Mat3T<Real> by = elastic.linear;
  for (int i = 0; i < 3; ++i) by(i, i) -= Real(1);
  by = share * by;
  for (int i = 0; i < 3; ++i) by(i, i) += Real(1);
  by = by * plastic.linear;
  // S S^p is not symmetric where their axes differ; its symmetric part keeps a pure stretch.
  next.linear = Real(0.5) * (by + transpose(by));
  for (int k = 0; k < kShapeModes; ++k) next.modes[k] += share * elastic.modes[k];
  const Real size = strain_size(next);
  if (size > law.max) {
    const Real kept = law.max / size;
    for (int i = 0; i < 3; ++i) next.linear(i, i) -= Real(1);
    next.linear = kept * next.linear;
    for (int i = 0; i < 3; ++i) next.linear(i, i) += Real(1);
    for (Vec3T<Real>& mode : next.modes) mode *= kept;
  }
  return next;
}

}  // namespace angio::simulation::detail

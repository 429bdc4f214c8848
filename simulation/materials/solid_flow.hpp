#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "simulation/materials/solid_law.hpp"
#include "simulation/materials/symmetric3.hpp"

/// How the wall's solid yields.
namespace angio::simulation::detail {

/// Deviator of a matrix's symmetric part.
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> deviator(const Mat3T<Real>& a) {
  Mat3T<Real> out = Real(0.5) * (a + transpose(a));
  const Real mean = (a(0, 0) + a(1, 1) + a(2, 2)) / Real(3);
  for (int i = 0; i < 3; ++i) out(i, i) -= mean;
  return out;
}

template <class Real>
ANGIO_HOST_DEVICE inline Real frobenius_norm(const Mat3T<Real>& a) {
  using std::sqrt;
  Real sum = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum += a(i, j) * a(i, j);
  return sqrt(sum);
}

/// The von Mises stress of the Kirchhoff stress P F^T [Pa].
template <class Real>
ANGIO_HOST_DEVICE inline Real von_mises_stress(const Mat3T<Real>& p, const Mat3T<Real>& f) {
  return Real(1.2247448713915890) * frobenius_norm(deviator(p * transpose(f)));
}

/// The von Mises stress [Pa] and the Mandel stress F^T P.
template <class Real>
struct YieldStress {
  Real von_mises{};
  Mat3T<Real> mandel;
};

template <class Real>
ANGIO_HOST_DEVICE inline YieldStress<Real> yield_stress(const SolidLaw<Real>& law,
                                                        const Vec3T<Real>* fiber,
                                                        const Mat3T<Real>& f) {
  SolidTangent<Real> tangent;
  const SolidStress<Real> s = solid_stress(law, fiber, f, tangent);
  if (!s.valid) return {};
  return {von_mises_stress(s.p, f), deviator(transpose(f) * s.p)};
}

/// A step of plastic flow at a point.
template <class Real>
struct FlowStep {
  Mat3T<Real> growth = Mat3T<Real>::identity();  ///< Fp <- growth Fp
  Real strain{};                                 ///< equivalent log strain that it adds
};

/// What flows at a held deformation: the stress above the yield stress decays at the creep rate.
///
///     F_e <- F_e exp(-g N),   Fp <- exp(g N) Fp,   N = dev sym(F_e^T P) / | . |
///     von Mises stress -> s_y + (s - s_y) exp(-c dt)     (c = 0: s_y)
///
/// with g >= 0 found so that the stress is met: the exponential return along the trial stress
/// (Weber, Anand, Comput. Methods Appl. Mech. Eng. 79 (1990) 173, Eqs. 52-59, without plastic
/// spin), for any law; it keeps the volume. Where fibres turn the stress the direction is renewed,
/// up to 20 times. The overstress decays as in Perzyna's viscoplasticity with a constant rate.
///
/// The stress is met to 1e-8 of it, in single precision to 4e-6.
///
/// @param elastic  F_e = dx/dX F0 Fp^-1
/// @param dt       [s]; used if the law creeps
template <class Real>
ANGIO_HOST_DEVICE inline FlowStep<Real> flow_solid(const SolidLaw<Real>& law,
                                                   const Vec3T<Real>* fiber, Mat3T<Real> elastic,
                                                   Real dt) {
  using std::exp;
  FlowStep<Real> out;
  if (!(law.yield > Real(0))) return out;
  YieldStress<Real> at = yield_stress(law, fiber, elastic);
  if (!(at.von_mises > law.yield)) return out;
  const Real kept = law.creep > Real(0) ? exp(-law.creep * dt) : Real(0);
  const Real target = law.yield + kept * (at.von_mises - law.yield);
  const Real close = Real(sizeof(Real) == 4 ? 4e-6 : 1e-8) * target;
  for (int turn = 0; turn < 20 && at.von_mises - target > close; ++turn) {
    const Real size = frobenius_norm(at.mandel);
    const Eigen3<Real> direction = eigen_decomposition((Real(1) / size) * at.mandel);
    const auto back = [&](Real g) {  // exp(-g N)
      Eigen3<Real> e = direction;
      for (int k = 0; k < 3; ++k) e.value[k] = exp(-g * direction.value[k]);
      return recomposed(e);
    };
    const auto over = [&](Real g) {
      return yield_stress(law, fiber, elastic * back(g)).von_mises - target;
    };
    // Bracket, by the line through the last two or twice as far; then regula falsi (Illinois); the
    // least stress on the way where it turns first.
    Real low = 0, at_low = at.von_mises - target, high = Real(1e-4), at_high = over(high);
    while (at_high > Real(0) && at_high < at_low && high < Real(4)) {
      const Real most = Real(7) * high;
      Real ahead = Real(1.1) * (high - low) * at_high / (at_low - at_high);
      ahead = ahead < high ? high : (ahead < most ? ahead : most);
      low = high;
      at_low = at_high;
      high += ahead;
      at_high = over(high);
    }
    Real g = low;
    if (at_high <= Real(0)) {
      for (int step = 0; step < 60 && high - low > Real(0); ++step) {
        g = step < 40 ? (low * at_high - high * at_low) / (at_high - at_low)
                      : Real(0.5) * (low + high);
        const Real value = over(g);
        if (value > -close && value < close) break;
        if (value > Real(0)) {
          low = g;
          at_low = value;
          at_high *= Real(0.5);
        } else {
          high = g;
          at_high = value;
          at_low *= Real(0.5);
        }
      }
    }
    if (!(g > Real(0))) break;
    elastic = elastic * back(g);
    out.growth = back(-g) * out.growth;
    out.strain += Real(0.81649658092772603) * g;
    at = yield_stress(law, fiber, elastic);
  }
  return out;
}

}  // namespace angio::simulation::detail

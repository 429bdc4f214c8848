#pragma once

#include <cmath>

#include "core/host_device.hpp"

/// What drives the balloon: gas, p V = Q with p absolute and Q = n R T, a pressure, or a volume.
namespace angio::simulation::detail {

/// What the inflator does within one step, as p(V) [Pa] of the enclosed volume V [mm^3]:
///
///     p = min(max(lower / V, slope_gas / V + slope_pressure), limit / V, top)
///
/// or, with `spring` > 0, p = slope_pressure - spring (V - volume): a prescribed volume whose
/// multiplier slope_pressure the solver moves, sweep by sweep, until V = volume.
/// Every part falls (or is flat) in V, so that it meets the balloon's rising V(p) once.
template <class Real>
struct GasLaw {
  Real lower{};           ///< [Pa mm^3]
  Real slope_gas{};       ///< [Pa mm^3]
  Real slope_pressure{};  ///< [Pa]
  Real limit{};           ///< the most gas that can be in the balloon now [Pa mm^3]
  Real top{};             ///< the greatest pressure [Pa]
  Real volume{};          ///< prescribed [mm^3]; 0: none
  Real spring{};          ///< [Pa/mm^3]
};

/// The same law in another precision.
template <class To, class From>
ANGIO_HOST_DEVICE inline GasLaw<To> converted(const GasLaw<From>& law) {
  return {To(law.lower), To(law.slope_gas), To(law.slope_pressure), To(law.limit),
          To(law.top),   To(law.volume),    To(law.spring)};
}

template <class Real>
ANGIO_HOST_DEVICE inline Real pressure_at(const GasLaw<Real>& law, Real volume) {
  if (law.spring > Real(0)) return law.slope_pressure - law.spring * (volume - law.volume);
  Real p = law.lower / volume;
  const Real raised = law.slope_gas / volume + law.slope_pressure;
  if (raised > p) p = raised;
  if (law.limit / volume < p) p = law.limit / volume;
  return law.top < p ? law.top : p;
}

/// Solves (p - shift) (volume + compliance (p - p0)) = gas for p: one hyperbola of the law against
/// a volume that grows linearly with pressure.
///
/// @param volume      at p0 [mm^3], > 0
/// @param compliance  dV/dp [mm^3/Pa], >= 0
template <class Real>
ANGIO_HOST_DEVICE inline Real meet_hyperbola(Real gas, Real shift, Real p0, Real volume,
                                             Real compliance) {
  using std::sqrt;
  const Real b = volume - compliance * (p0 - shift);
  const Real root = sqrt(b * b + Real(4) * compliance * gas);
  // The form without cancellation for either sign of b.
  const Real above = b >= Real(0) ? (b + root > Real(0) ? Real(2) * gas / (b + root) : Real(0))
                                  : (root - b) / (Real(2) * compliance);
  return shift + above;
}

/// The pressure [Pa] where the law meets V(p) = volume + compliance (p - p0).
template <class Real>
ANGIO_HOST_DEVICE inline Real meet(const GasLaw<Real>& law, Real p0, Real volume, Real compliance) {
  if (law.spring > Real(0))
    return p0 + (law.slope_pressure - law.spring * (volume - law.volume) - p0) /
                    (Real(1) + law.spring * compliance);
  Real p = meet_hyperbola(law.lower, Real(0), p0, volume, compliance);
  const Real raised = meet_hyperbola(law.slope_gas, law.slope_pressure, p0, volume, compliance);
  if (raised > p) p = raised;
  const Real limited = meet_hyperbola(law.limit, Real(0), p0, volume, compliance);
  if (limited < p) p = limited;
  return law.top < p ? law.top : p;
}

}  // namespace angio::simulation::detail

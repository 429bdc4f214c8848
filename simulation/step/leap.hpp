#pragma once

#include <cmath>

#include "core/host_device.hpp"

/// Sweeps go on with the leap: what a slow mode has left is added up at once.
///
/// Sweeps move one body after the other, so that a motion which balloon and wall share shrinks by
/// a factor q near 1 from sweep to sweep. Once the motions m, m' of two sweeps in a row lie along
/// each other the sum of all that would follow is m' q / (1 - q), q = m . m' / m . m.
///
/// Source: Lyusternik's acceleration, as in Faddeev, Faddeeva, "Computational Methods of Linear
/// Algebra" (1963), section 33; on vectors it is Aitken's.
namespace angio::simulation::detail {

/// What the leap remembers from sweep to sweep.
struct LeapStatus {
  int sweeps = 0;          ///< since the last leap, or the begin of the step
  double shrinkage = 0.0;  ///< q of the last two sweeps
};

inline constexpr double kAlong = 0.97;   // cosine of the two motions, at least
inline constexpr double kSlow = 0.6;     // q below which sweeps do as well
inline constexpr double kSteady = 0.15;  // change of 1 - q from sweep to sweep, at most, as a share
inline constexpr double kFarthestLeap = 25.0;  // q / (1 - q), at most
inline constexpr int kSweepsBeforeLeap = 3;

/// How far to leap along the last motion, as a multiple of it; 0: the motions are not one slow
/// mode.
///
/// @param total  m . m', m . m, m' . m' of the last two sweeps' motions
ANGIO_HOST_DEVICE inline double leap_length(LeapStatus& leap, const double (&total)[3]) {
  const double before = leap.shrinkage;
  const double q = leap.shrinkage = total[1] > 0.0 ? total[0] / total[1] : 0.0;
  const bool lies_along = total[0] > kAlong * std::sqrt(total[1] * total[2]);
  const bool is_steady = std::abs(q - before) < kSteady * (1.0 - before);
  if (leap.sweeps < kSweepsBeforeLeap || !(q > kSlow && q < 1.0) || !lies_along || !is_steady)
    return 0.0;
  const double length = q / (1.0 - q);
  return length < kFarthestLeap ? length : kFarthestLeap;
}

}  // namespace angio::simulation::detail

#pragma once

#include <cmath>

/// Numbers that a result of a balloon angioplasty is held against. Each stands here alone.
namespace angio::limits {

/// A stenosis with this fractional flow reserve or less limits flow (Tonino et al., FAME, N Engl J
/// Med 360 (2009) 213, doi:10.1056/NEJMoa0807611).
inline constexpr double kFlowLimitingFfr = 0.80;

/// Of the diameter [%]; with more, a lesion is not well prepared by a balloon alone (Jeger et al.,
/// third report of the International DCB Consensus Group, JACC Cardiovasc Interv 13 (2020) 1391,
/// doi:10.1016/j.jcin.2020.02.043).
inline constexpr double kMostResidualStenosisPercent = 30.0;

/// Diameter of the balloon at its peak over the reference diameter; above, dissections are more
/// frequent (489 lesions, Am Heart J, doi:10.1016/S0002-8703(07)80008-1).
inline constexpr double kMostBalloonToArteryRatio = 1.1;

/// Lumen beside the lesion at the peak over the same before: the same limit, and a tenth for what
/// diameters of a vessel vary by themselves.
inline constexpr double kMostWideningBeside = 1.2;

/// Is a value over a limit as both are told: in whole steps of so much?
inline bool is_over(double value, double limit, double step) {
  return std::round(value / step) > std::round(limit / step);
}

}  // namespace angio::limits

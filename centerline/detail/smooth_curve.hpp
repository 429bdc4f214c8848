#pragma once

#include <cstddef>
#include <vector>

#include "core/vec3.hpp"

namespace angio::centerline {

/// What a look at the wall says of each point of a line.
struct Middles {
  std::vector<Vec3> center;    ///< [mm]
  std::vector<double> weight;  ///< 0: nothing was seen there; 1: a section that can be trusted
};

/// The curve that follows the middles and is as smooth as a vessel is:
///
///     x = argmin sum_i w_i |x_i - c_i|^2 + sum_i l_i^6 |D3 x_i|^2 + sum_i (0.3 l_i)^4 |D2 x_i|^2
///
/// with D3 and D2 the third and second differences of neighbouring points (a discrete smoothing
/// spline of order three: Whittaker, Proc. Edinb. Math. Soc. 41:63, 1923; Reinsch, Numer. Math.
/// 10:177, 1967). On even points it keeps what is longer than 2 pi l points and takes away what is
/// shorter, by 1 / (1 + (2 pi l / length)^6): bends of vessels pass unchanged, zigzags do not. The
/// second differences matter where no middle is seen: there the curve does not curl.
/// Middles that lie off the curve by much more than the others count nothing (Tukey's biweight, so
/// that a section which looked into a neighbour does not pull the line there). Where nothing was
/// seen the curve goes on from both sides.
///
/// @param fixed      points [0, fixed) stay
/// @param stiffness  l, in points, > 0; shape [point]
/// @param tolerance  middles that are farther off than this [mm], or than six times the median
///                   distance of those beside them, count nothing; shape [point]
std::vector<Vec3> smooth_curve(const std::vector<Vec3>& points, const Middles& middles,
                               std::size_t fixed, const std::vector<double>& stiffness,
                               const std::vector<double>& tolerance);

}  // namespace angio::centerline

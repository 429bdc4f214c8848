#pragma once

#include <Eigen/Dense>
#include <utility>
#include <vector>

#include "reconstruction/detail/tree_curves.hpp"

/// What is taken for granted of a tree before its frames are seen: curves and radii change slowly
/// along them. How slowly is found from the frames.
namespace angio::reconstruction::detail {

/// Spreads of the differences of neighbouring nodes (P-splines: Eilers, Marx, Stat. Sci. 11:89,
/// 1996): third ones of the places, across the curve, so that a circle costs nothing; second ones
/// of ln radius, so that a taper costs nothing.
struct Smoothness {
  double place_sd = 0.05;   ///< [mm]
  double radius_sd = 0.05;  ///< of ln radius
};

/// Normal equations of the prior, -2 ln of its density without constants.
struct PriorEquations {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  double cost = 0.0;
};

/// Of parameters three to a node, and one more that it leaves alone. Where a curve leaves another,
/// its first point lies on it to a tenth of the radius.
PriorEquations prior_equations(const TreeCurves& curves, const Smoothness& smoothness);

/// The spreads under which the frames are most likely (evidence):
///
///     sd^2 = |D x|^2 / (k - tr(D C D^T) / sd^2)
///
/// D: differences, k: how many; C: covariance of the parameters x given the frames and the spreads
/// before (MacKay, Neural Comput. 4:415, 1992, eq. 4.8 and 4.9). Repeated, it converges.
Smoothness likelier_smoothness(const TreeCurves& curves, const Smoothness& before,
                               const Eigen::MatrixXd& covariance);

}  // namespace angio::reconstruction::detail

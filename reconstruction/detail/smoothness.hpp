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
/// of ln radius, so that a taper costs nothing. Those of radius come from Student's t distribution:
/// vessels are smooth nearly everywhere, and narrow suddenly where they are ill; one spread for
/// both would widen every throat.
struct Smoothness {
  double place_sd = 0.05;   ///< [mm]
  double radius_sd = 0.05;  ///< of ln radius: the distribution's scale
  /// Of each second difference of ln radius, curve after curve; empty: `radius_sd`.
  std::vector<double> own_radius_sd = {};
};

/// Of Student's distribution of second differences of ln radius: so few that a throat is an
/// outlier, enough for a variance of the rest.
inline constexpr double kFreedom = 2.0;

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
/// before (MacKay, Neural Comput. 4:415, 1992, eq. 4.8 and 4.9). A difference d of ln radius has a
/// spread of its own,
///
///     sd_d^2 = (nu sd^2 + d^2 + var d) / (nu + 1)
///
/// (Student's t with nu degrees of freedom as a mixture of Gaussians: Lange, Little, Taylor, J. Am.
/// Stat. Assoc. 84:881, 1989), and counts as d sd / sd_d above. Repeated, it converges.
Smoothness likelier_smoothness(const TreeCurves& curves, const Smoothness& before,
                               const Eigen::MatrixXd& covariance);

}  // namespace angio::reconstruction::detail

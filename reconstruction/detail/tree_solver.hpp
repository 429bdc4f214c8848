#pragma once

#include <Eigen/Dense>
#include <vector>

#include "core/progress.hpp"
#include "reconstruction/detail/fit_equations.hpp"
#include "reconstruction/detail/smoothness.hpp"

namespace angio::reconstruction::detail {

/// All that is fitted.
struct FitState {
  TreeCurves curves;
  double width_pixels = 1.0;  ///< of the box by which pixels see the vessel
  std::vector<FrameState> frames;
  Smoothness smoothness;
};

struct TreeSolution {
  FitState state;
  Eigen::MatrixXd covariance;  ///< of the tree's parameters, and ln of the width last
  double correlation = 1.0;    ///< correlation_of()
  int steps = 0;
  bool converged = false;
};

/// Minimises by damped Gauss-Newton steps (Marquardt, J. SIAM 11:431, 1963), each frame's own
/// numbers eliminated; after every few steps the noise and the smoothness are found again.
///
/// @param state  the frames' contrast and background need no values
TreeSolution solve_tree(const std::vector<FitFrame>& frames, FitState state,
                        const MotionPrior& prior, int most_steps, const Progress& progress);

}  // namespace angio::reconstruction::detail

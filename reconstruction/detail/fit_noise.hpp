#pragma once

#include <vector>

#include "reconstruction/detail/fit_equations.hpp"

namespace angio::reconstruction::detail {

/// The noise of a frame's pixels by what its model leaves: 1.4826 times the median size of the
/// residuals, which a few strangers do not change, widened for the numbers fitted to them.
double noise_of(const FrameEquations& equations);

/// By how much neighbours' residuals agree: the sum of their correlations over two pixels to all
/// sides; 1 of independent ones, and never less. Noise that a detector has blurred, and what the
/// model cannot follow, have more.
double correlation_of(const std::vector<FitFrame>& frames,
                      const std::vector<FrameEquations>& equations);

}  // namespace angio::reconstruction::detail

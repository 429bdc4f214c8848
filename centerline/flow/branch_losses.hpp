#pragma once

#include <vector>

#include "centerline/flow/flow.hpp"

namespace angio::centerline {

/// What a branch takes from its inlet to each of its points; shape [point], none falls.
struct BranchLosses {
  std::vector<double> friction;   ///< integral of 8 / (pi r^4) ds [1/mm^3]: times viscosity and Q
  std::vector<double> expansion;  ///< sum of (1/A_throat - 1/A)^2 [1/mm^4]: times Kt rho/2 and Q^2
};

/// The radii of a branch with the unmeasured ones filled in [mm], shape [point]: linear between
/// measured neighbours, as the nearest one at the ends; the healthy ones where there is none.
std::vector<double> filled_radii(const FlowBranch& branch);

/// @param radius  [mm], > 0, shape [point]
/// @param opens_into  radius that a throat at the branch's end widens to [mm]; 0: it does not
BranchLosses branch_losses(const std::vector<double>& abscissa, const std::vector<double>& radius,
                           double opens_into);

}  // namespace angio::centerline

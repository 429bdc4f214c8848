#pragma once

#include <array>
#include <vector>

#include "reconstruction/detail/voxel_projector.hpp"

namespace angio::reconstruction::detail {

/// Which chosen voxel lies beside each, along i, j, k; -1: none, where the value is zero.
struct Neighbours {
  std::vector<std::array<int, 3>> after, before;
};
Neighbours neighbours(const ChosenVoxels& voxels);

/// Takes noise out of values that are nowhere negative, and leaves edges:
///
///     min over x >= 0:  1/2 |x - b|^2 + strength TV(x),   TV(x) = sum |(x_i+1 - x, x_j+1 - x,
///     x_k+1 - x)|
///
/// by fast gradient projection of its dual (Beck, Teboulle, IEEE Trans. Image Process. 18:2419,
/// 2009, algorithm FGP, with a step of 1 / 12 in three dimensions). Voxels that are not chosen are
/// zero.
/// @param noisy     b, in the unit of the values
/// @param strength  in the same unit, >= 0
/// @param dual      what the last call left, to go on from; empty at first
std::vector<float> smooth_by_total_variation(const std::vector<float>& noisy, float strength,
                                             const Neighbours& beside, int iterations,
                                             std::vector<std::array<float, 3>>& dual);

double total_variation(const std::vector<float>& values, const Neighbours& beside);

}  // namespace angio::reconstruction::detail

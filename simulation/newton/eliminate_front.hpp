#pragma once

#include <cstddef>

namespace angio::simulation::detail {

/// Eliminates the first columns of a dense symmetric matrix: they become those of L (unit lower),
/// and the lower right corner what they leave, A22 - L21 D L21^T. Where a sparse factorisation's
/// time goes.
///
/// @param front   its lower triangle, column by column, shape [size, size]
/// @param count   columns to eliminate, at most `size`
/// @param pivots  D, shape [count]
/// @return the number of negative pivots; -1 where one is zero or not finite
int eliminate_front(double* front, std::ptrdiff_t size, std::ptrdiff_t count, double* pivots);

}  // namespace angio::simulation::detail

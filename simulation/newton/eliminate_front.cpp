#include "simulation/newton/eliminate_front.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"

namespace angio::simulation::detail {

int eliminate_front(double* front_data, std::ptrdiff_t size, std::ptrdiff_t count, double* pivots) {
  constexpr Eigen::Index kPanel = 32, kStrip = 96;
  Eigen::Map<Eigen::MatrixXd> front(front_data, size, size);
  int negative = 0;
  Eigen::MatrixXd scaled;
  for (Eigen::Index begin = 0; begin < count; begin += kPanel) {
    const Eigen::Index width = std::min<Eigen::Index>(kPanel, count - begin), end = begin + width;
    for (Eigen::Index j = begin; j < end; ++j) {
      const double pivot = front(j, j);
      if (!std::isfinite(pivot) || pivot == 0.0) return -1;
      negative += pivot < 0.0 ? 1 : 0;
      pivots[j] = pivot;
      auto column = front.col(j).tail(size - j - 1);
      for (Eigen::Index k = j + 1; k < end; ++k)
        front.col(k).tail(size - k) -= (front(k, j) / pivot) * front.col(j).tail(size - k);
      column /= pivot;
    }
    const Eigen::Index rest = size - end;
    if (rest == 0) continue;
    const auto l = front.block(end, begin, rest, width);
    scaled = l * Eigen::Map<const Eigen::VectorXd>(pivots + begin, width).asDiagonal();
    auto left = front.bottomRightCorner(rest, rest);
    // In strips of columns, which threads share; the last one's are few rows.
    parallel_for_uneven((rest + kStrip - 1) / kStrip, [&](std::ptrdiff_t strip) {
      const Eigen::Index from = strip * kStrip, columns = std::min(kStrip, rest - from),
                         below = rest - from - columns;
      left.block(from, from, columns, columns).triangularView<Eigen::Lower>() -=
          scaled.middleRows(from, columns) * l.middleRows(from, columns).transpose();
      left.block(from + columns, from, below, columns).noalias() -=
          scaled.bottomRows(below) * l.middleRows(from, columns).transpose();
    });
  }
  return negative;
}

}  // namespace angio::simulation::detail

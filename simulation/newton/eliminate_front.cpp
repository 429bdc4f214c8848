#include "simulation/newton/eliminate_front.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace angio::simulation::detail {

int eliminate_front(double* front_data, std::ptrdiff_t size, std::ptrdiff_t count, double* pivots) {
  constexpr Eigen::Index kPanel = 32;
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
    front.bottomRightCorner(rest, rest).triangularView<Eigen::Lower>() -= scaled * l.transpose();
  }
  return negative;
}

}  // namespace angio::simulation::detail

#include "simulation/materials/shape_modes.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "simulation/materials/shape_matching.hpp"

namespace angio::simulation::detail {
namespace {

// Combinations smaller than this share of the greatest one, squared, are rounding.
constexpr double kLeastMode = 1e-6;

using Columns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>;

}  // namespace

std::vector<double> quadratic_modes(const std::vector<Vec3>& offset,
                                    const std::vector<double>& weight) {
  const auto count = Eigen::Index(offset.size());
  double total = 0.0, spread = 0.0;
  for (std::size_t i = 0; i < offset.size(); ++i) {
    total += weight[i];
    spread += weight[i] * norm_squared(offset[i]);
  }
  const double size = std::sqrt(spread / total);
  // Rows times the root of their weight, lengths over the size.
  Columns plain(count, 4), squares(count, kShapeModes);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double w = std::sqrt(weight[std::size_t(i)] / total);
    const Vec3 q = offset[std::size_t(i)] / size;
    plain.row(i) << w, w * q.x, w * q.y, w * q.z;
    squares.row(i) << w * q.x * q.x, w * q.y * q.y, w * q.z * q.z, w * q.x * q.y, w * q.y * q.z,
        w * q.z * q.x;
  }
  Eigen::ColPivHouseholderQR<Columns> qr(plain);
  qr.setThreshold(1e-8);
  const Columns basis = qr.householderQ() * Columns::Identity(count, qr.rank());
  for (int pass = 0; pass < 2; ++pass)  // twice is enough against rounding
    squares -= basis * (basis.transpose() * squares);
  const Eigen::SelfAdjointEigenSolver<Columns> eigen(squares.transpose() * squares);
  const double most = eigen.eigenvalues()(kShapeModes - 1);
  std::vector<double> modes(offset.size() * kShapeModes, 0.0);
  for (int k = 0; k < kShapeModes; ++k) {
    const double square = eigen.eigenvalues()(k);
    if (!(square > kLeastMode * std::max(most, 1e-6))) continue;
    const Eigen::VectorXd mode = squares * eigen.eigenvectors().col(k) / std::sqrt(square);
    for (Eigen::Index i = 0; i < count; ++i)
      modes[std::size_t(i) * kShapeModes + std::size_t(k)] =
          size * mode(i) / std::sqrt(weight[std::size_t(i)] / total);
  }
  return modes;
}

}  // namespace angio::simulation::detail

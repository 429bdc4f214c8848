#include "centerline/detail/smooth_curve.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

namespace angio::centerline {
namespace {

/// Middles count this much at least, or a stretch without any could lie anywhere.
constexpr double kLeastWeight = 1e-6;
/// The scale of the second differences over that of the third ones.
constexpr double kTension = 0.3;

/// One linear least-squares solve; rows of fixed points are moved to the right-hand side.
std::vector<Vec3> solve(const std::vector<Vec3>& points, const std::vector<Vec3>& center,
                        const std::vector<double>& weight, std::size_t fixed,
                        const std::vector<double>& stiffness) {
  const auto count = std::ptrdiff_t(points.size()), first = std::ptrdiff_t(fixed);
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(count - first, 3);
  for (std::ptrdiff_t i = first; i < count; ++i) {
    const double w = weight[std::size_t(i)];
    entries.emplace_back(int(i - first), int(i - first), w);
    for (int axis = 0; axis < 3; ++axis) right(i - first, axis) += w * center[std::size_t(i)][axis];
  }
  const auto penalise = [&](const std::vector<double>& difference, double power, double share) {
    const auto terms = std::ptrdiff_t(difference.size());
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(first - terms + 1, 0); i + terms <= count;
         ++i) {
      const double penalty = std::pow(share * stiffness[std::size_t(i + terms / 2)], power);
      for (std::ptrdiff_t a = 0; a < terms; ++a) {
        if (i + a < first) continue;
        for (std::ptrdiff_t b = 0; b < terms; ++b) {
          const double value = penalty * difference[std::size_t(a)] * difference[std::size_t(b)];
          if (i + b >= first)
            entries.emplace_back(int(i + a - first), int(i + b - first), value);
          else
            for (int axis = 0; axis < 3; ++axis)
              right(i + a - first, axis) -= value * points[std::size_t(i + b)][axis];
        }
      }
    }
  };
  penalise({-1.0, 3.0, -3.0, 1.0}, 6.0, 1.0);
  penalise({1.0, -2.0, 1.0}, 4.0, kTension);
  Eigen::SparseMatrix<double> matrix(count - first, count - first);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower,
                              Eigen::NaturalOrdering<int>>
      factor(matrix);
  const Eigen::MatrixX3d solved = factor.solve(right);
  std::vector<Vec3> result = points;
  for (std::ptrdiff_t i = first; i < count; ++i)
    result[std::size_t(i)] = {solved(i - first, 0), solved(i - first, 1), solved(i - first, 2)};
  return result;
}

/// Six times the median distance of the middles near each point from the curve, or the tolerance.
std::vector<double> cut_offs(const std::vector<double>& off, const std::vector<double>& weight,
                             const std::vector<double>& tolerance) {
  constexpr std::size_t kNear = 12;  // points to each side
  constexpr double kFar = 6.0;
  std::vector<double> cut(off.size()), near;
  for (std::size_t i = 0; i < off.size(); ++i) {
    near.clear();
    for (std::size_t k = i - std::min(i, kNear); k < std::min(i + kNear + 1, off.size()); ++k)
      if (weight[k] > 0.0) near.push_back(off[k]);
    double median = 0.0;
    if (!near.empty()) {
      const auto middle = near.begin() + std::ptrdiff_t(near.size() / 2);
      std::nth_element(near.begin(), middle, near.end());
      median = *middle;
    }
    cut[i] = std::min(std::max(kFar * median, 0.1 * tolerance[i]), tolerance[i]);
  }
  return cut;
}

}  // namespace

std::vector<Vec3> smooth_curve(const std::vector<Vec3>& points, const Middles& middles,
                               std::size_t fixed, const std::vector<double>& stiffness,
                               const std::vector<double>& tolerance) {
  constexpr int kPasses = 4;
  std::vector<double> weight = middles.weight;
  for (double& w : weight) w = std::max(w, kLeastWeight);
  std::vector<Vec3> curve = points;
  if (points.size() < fixed + 2) return curve;
  for (int pass = 0; pass < kPasses; ++pass) {
    curve = solve(points, middles.center, weight, fixed, stiffness);
    std::vector<double> off(points.size());
    for (std::size_t i = 0; i < off.size(); ++i) off[i] = distance(curve[i], middles.center[i]);
    const std::vector<double> cut = cut_offs(off, middles.weight, tolerance);
    for (std::size_t i = fixed; i < off.size(); ++i) {
      const double u = off[i] / cut[i], keep = u < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
      weight[i] = std::max(keep * middles.weight[i], kLeastWeight);
    }
  }
  return curve;
}

}  // namespace angio::centerline

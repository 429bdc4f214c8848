#include "reconstruction/detail/smoothness.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace angio::reconstruction::detail {
namespace {

enum class Kind { place, radius, joint };

/// A number that should be about zero: its value now, and its derivatives.
struct Row {
  Kind kind = Kind::place;
  double value = 0.0, sd = 1.0;
  std::vector<std::pair<int, double>> by;
};

/// Adds how far a node lies along a direction.
void add_node(Row& row, const TreeCurve& curve, std::size_t node, const Vec3& along,
              double weight) {
  const int first = curve.first_parameter + 3 * int(node);
  row.value += weight * dot(curve.node[node], along);
  row.by.emplace_back(first, weight * dot(curve.first_normal[node], along));
  row.by.emplace_back(first + 1, weight * dot(curve.second_normal[node], along));
}

/// @param own_sd  of the curve's differences of ln radius, or null
void add_differences(const TreeCurve& curve, const Smoothness& smoothness, const double* own_sd,
                     std::vector<Row>& rows) {
  constexpr std::array<double, 4> kThird = {-1.0, 3.0, -3.0, 1.0};
  constexpr std::array<double, 3> kSecond = {1.0, -2.0, 1.0};
  for (std::size_t n = 0; n + 4 <= curve.node.size(); ++n)
    for (const Vec3& across : {curve.first_normal[n + 1], curve.second_normal[n + 1]}) {
      Row& row = rows.emplace_back(Row{Kind::place, 0.0, smoothness.place_sd, {}});
      for (std::size_t k = 0; k < 4; ++k) add_node(row, curve, n + k, across, kThird[k]);
    }
  for (std::size_t n = 0; n + 3 <= curve.node.size(); ++n) {
    Row& row =
        rows.emplace_back(Row{Kind::radius, 0.0, own_sd ? own_sd[n] : smoothness.radius_sd, {}});
    for (std::size_t k = 0; k < 3; ++k) {
      row.value += kSecond[k] * curve.log_radius[n + k];
      row.by.emplace_back(curve.first_parameter + 3 * int(n + k) + 2, kSecond[k]);
    }
  }
}

void add_joint(const TreeCurve& curve, const TreeCurve& parent, std::vector<Row>& rows) {
  constexpr double kPartOfRadius = 0.1;
  const double sd = kPartOfRadius * std::exp(parent.at(curve.joint).log_radius);
  const SplinePlace start = curve.place(0.0);
  for (const Vec3& along : {Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}}) {
    Row& row = rows.emplace_back(Row{Kind::joint, 0.0, sd, {}});
    for (std::size_t a = 0; a < 4; ++a) {
      add_node(row, curve, std::size_t(start.first_node) + a, along, start.value[a]);
      add_node(row, parent, std::size_t(curve.joint.first_node) + a, along, -curve.joint.value[a]);
    }
  }
}

std::vector<Row> prior_rows(const TreeCurves& curves, const Smoothness& smoothness) {
  std::vector<Row> rows;
  std::size_t first = 0;
  for (const TreeCurve& curve : curves.curves) {
    const std::vector<double>& own = smoothness.own_radius_sd;
    add_differences(curve, smoothness, own.empty() ? nullptr : own.data() + first, rows);
    first += std::max<std::size_t>(curve.node.size(), 2) - 2;
    if (curve.parent >= 0) add_joint(curve, curves.curves[std::size_t(curve.parent)], rows);
  }
  return rows;
}

}  // namespace

PriorEquations prior_equations(const TreeCurves& curves, const Smoothness& smoothness) {
  const int count = 3 * curves.node_count() + 1;
  PriorEquations equations{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count), 0.0};
  for (const Row& row : prior_rows(curves, smoothness)) {
    const double information = 1.0 / (row.sd * row.sd);
    equations.cost += information * row.value * row.value;
    for (const auto& [i, by_i] : row.by) {
      equations.right[i] -= information * by_i * row.value;
      for (const auto& [j, by_j] : row.by) equations.normal(i, j) += information * by_i * by_j;
    }
  }
  return equations;
}

Smoothness likelier_smoothness(const TreeCurves& curves, const Smoothness& before,
                               const Eigen::MatrixXd& covariance) {
  constexpr double kLeastPlace = 1e-4, kLeastRadius = 1e-4, kMost = 1.0;
  const double scale = before.radius_sd * before.radius_sd;
  std::vector<double> own_radius_sd;
  std::array<double, 2> squares{}, told{};  // sum of squares; how many the frames tell
  for (const Row& row : prior_rows(curves, before)) {
    if (row.kind == Kind::joint) continue;
    double spread = 0.0;
    for (const auto& [i, by_i] : row.by)
      for (const auto& [j, by_j] : row.by) spread += by_i * covariance(i, j) * by_j;
    const std::size_t which = row.kind == Kind::place ? 0 : 1;
    double weight = 1.0;  // d counts as sqrt(weight) d
    if (row.kind == Kind::radius) {
      const double own = (kFreedom * scale + row.value * row.value + spread) / (kFreedom + 1.0);
      weight = scale / own;
      own_radius_sd.push_back(std::sqrt(own));
    }
    squares[which] += weight * row.value * row.value;
    told[which] += 1.0 - std::min(1.0, spread / (row.sd * row.sd));
  }
  const auto sd = [&](std::size_t which, double least, double otherwise) {
    if (told[which] < 1.0) return otherwise;
    return std::clamp(std::sqrt(squares[which] / told[which]), least, kMost);
  };
  return {sd(0, kLeastPlace, before.place_sd), sd(1, kLeastRadius, before.radius_sd),
          std::move(own_radius_sd)};
}

}  // namespace angio::reconstruction::detail

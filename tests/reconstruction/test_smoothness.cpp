#include <gtest/gtest.h>

#include <cmath>

#include "reconstruction/detail/smoothness.hpp"

namespace angio::reconstruction::detail {
namespace {

/// A straight vessel that narrows suddenly by half and widens again.
TreeCurves narrowing_vessel() {
  CenterlineTree tree;
  CenterlinePath& path = tree.paths.emplace_back();
  for (double z = 0.0; z <= 30.0; z += 0.25) {
    path.points.push_back({0.0, 0.0, z});
    path.inscribed_radius.push_back(1.5 - 0.75 * std::exp(-0.5 * (z - 15.0) * (z - 15.0)) +
                                    0.001 * std::sin(40.0 * z));
  }
  path.abscissa = arc_length(path.points);
  return make_curves(tree, 0.75, 0.25);
}

double second_difference(const TreeCurve& curve, std::size_t n) {
  return curve.log_radius[n] - 2.0 * curve.log_radius[n + 1] + curve.log_radius[n + 2];
}

TEST(Smoothness, GivesEachChangeOfRadiusTheSpreadOfItsOwn) {
  const TreeCurves curves = narrowing_vessel();
  const TreeCurve& curve = curves.curves[0];
  const int count = 3 * curves.node_count() + 1;
  const Smoothness before;
  const Smoothness after = likelier_smoothness(curves, before, Eigen::MatrixXd::Zero(count, count));
  ASSERT_EQ(after.own_radius_sd.size(), curve.node.size() - 2);
  double squares = 0.0;
  for (std::size_t n = 0; n < after.own_radius_sd.size(); ++n) {
    const double d = second_difference(curve, n), own = after.own_radius_sd[n];
    EXPECT_NEAR(own * own,
                (kFreedom * before.radius_sd * before.radius_sd + d * d) / (kFreedom + 1.0), 1e-12);
    squares += d * d * before.radius_sd * before.radius_sd / (own * own);
  }
  EXPECT_NEAR(after.radius_sd, std::sqrt(squares / double(after.own_radius_sd.size())), 1e-12);
}

/// Repeated, the spread is that of the healthy vessel, and a throat costs little.
TEST(Smoothness, IsThatOfTheHealthyVessel) {
  const TreeCurves curves = narrowing_vessel();
  const int count = 3 * curves.node_count() + 1;
  Smoothness smoothness;
  for (int n = 0; n < 50; ++n)
    smoothness = likelier_smoothness(curves, smoothness, Eigen::MatrixXd::Zero(count, count));
  double all = 0.0;
  const TreeCurve& curve = curves.curves[0];
  for (std::size_t n = 0; n + 2 < curve.node.size(); ++n)
    all += std::pow(second_difference(curve, n), 2) / double(curve.node.size() - 2);
  EXPECT_LT(smoothness.radius_sd, 0.2 * std::sqrt(all));
}

TEST(Smoothness, CostsWhatItsSpreadsSay) {
  const TreeCurves curves = narrowing_vessel();
  Smoothness smoothness;
  const double one = prior_equations(curves, smoothness).cost;
  smoothness.own_radius_sd.assign(curves.curves[0].node.size() - 2, 2.0 * smoothness.radius_sd);
  EXPECT_NEAR(prior_equations(curves, smoothness).cost, 0.25 * one, 1e-9 * one);
}

}  // namespace
}  // namespace angio::reconstruction::detail

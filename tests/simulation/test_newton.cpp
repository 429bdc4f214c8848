#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "simulation/newton/newton.hpp"
#include "simulation/newton/sparse_ldlt.hpp"
#include "testing/simulation/spheres.hpp"

namespace angio::simulation::detail {
namespace {

using namespace testing;

// Stretch error of a sphere of 10 n^2 + 2 vertices on the radius, under pressures for stretches l.
std::vector<double> stretch_errors(int n, const std::vector<double>& stretches) {
  const Sphere sphere(n);
  std::vector<Vec3> x = sphere.mesh.vertices;
  std::vector<double> errors;
  for (const double l : stretches) {
    const auto result = sphere.solve(Enclosure::Control::pressure, sphere_pressure(l, 1.5), x);
    EXPECT_TRUE(result.converged) << l;
    errors.push_back(std::cbrt(result.volume / sphere.volume) / l - 1.0);
  }
  return errors;
}

TEST(Newton, ASphereFollowsItsClosedFormAndItsErrorFallsFourfoldWithRefinement) {
  const std::vector<double> l{1.05, 1.1, 1.2, 1.5, 2.0, 2.5, 3.0};
  const auto coarse = stretch_errors(7, l), fine = stretch_errors(14, l);  // 492, 1962 vertices
  for (std::size_t i = 0; i < l.size(); ++i) {
    EXPECT_LT(std::abs(coarse[i]), l[i] < 1.21 ? 0.0015 : 0.006) << l[i];
    EXPECT_LT(std::abs(fine[i]), l[i] < 1.21 ? 0.0015 : 0.006) << l[i];
    EXPECT_NEAR(coarse[i] / fine[i], 4.0, 0.1) << l[i];
  }
}

TEST(Newton, ConvergesQuadratically) {
  const Sphere sphere(7);
  std::vector<Vec3> x = sphere.mesh.vertices;
  const auto all = sphere.solve(Enclosure::Control::pressure, sphere_pressure(1.5, 1.5), x);
  EXPECT_TRUE(all.converged);
  EXPECT_LE(all.iterations, 12);
  EXPECT_LT(all.residual, 1e-9);
}

TEST(Newton, VolumeControlFindsThePressureOfThatVolume) {
  const Sphere sphere(4);
  for (const double l : {0.97, 1.1, 1.6}) {
    std::vector<Vec3> x = sphere.mesh.vertices, y = x;
    const double target = l * l * l * sphere.volume;
    const auto by_volume = sphere.solve(Enclosure::Control::volume, target, x);
    EXPECT_TRUE(by_volume.converged);
    EXPECT_NEAR(by_volume.volume, target, 1e-9 * target);
    y = x;
    const auto by_pressure = sphere.solve(Enclosure::Control::pressure, by_volume.pressure, y);
    EXPECT_NEAR(by_pressure.volume, target, 1e-6 * target);
  }
}

TEST(Newton, GasObeysItsLaw) {
  const Sphere sphere(4);
  const double outside = 101325.0 + 1e4;
  for (const double fill : {0.9, 1.0, 2.0, 10.0}) {
    std::vector<Vec3> x = sphere.mesh.vertices;
    const double gas = fill * outside * sphere.volume;
    const auto result = sphere.solve(Enclosure::Control::gas, gas, x, outside);
    EXPECT_TRUE(result.converged) << fill;
    EXPECT_NEAR((result.pressure + outside) * result.volume, gas, 1e-6 * gas);
    EXPECT_EQ(result.pressure > 0.0, fill > 1.0 + 1e-12);
  }
}

TEST(Newton, WorkOfThePressureIsTheChangeOfEnergyThereAndBack) {
  const Sphere sphere(4);
  std::vector<Vec3> x = sphere.mesh.vertices;
  double work = 0.0, volume = sphere.volume, pressure = 0.0, energy = 0.0;
  const int steps = 24;
  for (int k = 1; k <= 2 * steps; ++k) {
    const double l = 1.0 + 0.6 * (k <= steps ? k : 2 * steps - k) / steps;
    const auto r = sphere.solve(Enclosure::Control::volume, l * l * l * sphere.volume, x);
    ASSERT_TRUE(r.converged);
    work += 0.5 * (pressure + r.pressure) * (r.volume - volume);
    volume = r.volume;
    pressure = r.pressure;
    if (k == steps) {
      energy = r.energy;
      EXPECT_NEAR(work, energy, 0.01 * energy);
    }
    if (k == 2 * steps) {
      EXPECT_NEAR(work, 0.0, 1e-6 * energy);
      EXPECT_NEAR(r.energy, 0.0, 1e-9 * energy);
    }
  }
}

TEST(Newton, AnUnloadedBodyStaysWhereItIs) {
  const Sphere sphere(4);
  std::vector<Vec3> x = sphere.mesh.vertices;
  const auto result = sphere.solve(Enclosure::Control::pressure, 0.0, x);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.iterations, 0);
}

TEST(Newton, TheSameInputGivesTheSameBits) {
  const Sphere sphere(4);
  std::vector<Vec3> x = sphere.mesh.vertices, y = x;
  sphere.solve(Enclosure::Control::pressure, sphere_pressure(1.3, 1.5), x);
  sphere.solve(Enclosure::Control::pressure, sphere_pressure(1.3, 1.5), y);
  EXPECT_EQ(x, y);
}

// A spring between two points, k / 2 (|x0 - x1| - 1)^2: indefinite when pressed.
class Spring final : public EnergyTerm {
 public:
  [[nodiscard]] double value(const std::vector<Vec3>& x) const override {
    const double s = distance(x[0], x[1]) - 1.0;
    return 0.5 * kStiffness * s * s;
  }
  void add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const override {
    const Vec3 d = x[0] - x[1];
    const double length = norm(d), force = kStiffness * (length - 1.0);
    const Vec3 n = d / length;
    out.add_gradient(0, force * n);
    out.add_gradient(1, -force * n);
    const double across = clamp ? std::max(0.0, force / length) : force / length;
    const Mat3 block = (kStiffness - across) * outer(n, n) + across * Mat3::identity();
    out.add_block(0, 0, block);
    out.add_block(0, 1, -1.0 * block);
    out.add_block(1, 1, block);
  }
  static constexpr double kStiffness = 7.0;
};

TEST(Newton, FindsTheMinimumWhereTheHessianIsNotPositive) {
  const Spring spring;
  std::vector<Vec3> x{{0, 0, 0}, {0.3, 0.2, 0.0}};
  const auto result = minimize({&spring}, {kFixedAll, 0}, x, {});
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(distance(x[0], x[1]), 1.0, 1e-8);
  EXPECT_EQ(x[0], Vec3{});
}

TEST(Newton, InertiaMakesImplicitEulerSteps) {
  // A mass on a spring along x: (m / dt^2 + k) u = m / dt^2 (u + dt v), exactly.
  const Spring spring;
  const double m = 2.0, dt = 0.1, u = 0.05, v = 0.3, k = Spring::kStiffness;
  std::vector<Vec3> x{{0, 0, 0}, {1.0 + u, 0, 0}};
  const InertiaTerm inertia({0.0, m}, {x[0], x[1] + Vec3{dt * v, 0, 0}}, dt);
  const auto result = minimize({&spring, &inertia}, {kFixedAll, 0}, x, {});
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(x[1].x - 1.0, (u + dt * v) / (1.0 + k * dt * dt / m), 1e-9);
}

// A grid of points with three unknowns each, joined to their neighbours.
Eigen::SparseMatrix<double> grid_matrix(int side, double diagonal) {
  std::mt19937 random(5u);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < 3 * side * side; ++i)
    for (int j = 0; j <= i; ++j) {
      const int a = i / 3, b = j / 3;
      if (std::abs(a / side - b / side) <= 1 && std::abs(a % side - b % side) <= 1)
        entries.emplace_back(i, j, i == j ? diagonal + u(random) : u(random));
    }
  Eigen::SparseMatrix<double> lower(3 * side * side, 3 * side * side);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

TEST(SparseLdlt, SolvesAndCountsTheNegativeEigenvalues) {
  for (const double diagonal : {0.3, 2.0, 30.0}) {
    const Eigen::SparseMatrix<double> lower = grid_matrix(9, diagonal);
    const Eigen::SparseMatrix<double> both = lower.selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd whole(both);
    SparseLdlt ldlt;
    ldlt.analyze(lower);
    for (const double shift : {0.0, 1.5}) {
      const Eigen::MatrixXd shifted =
          whole + shift * Eigen::MatrixXd::Identity(whole.rows(), whole.cols());
      const Eigen::VectorXd eigenvalues =
          Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(shifted).eigenvalues();
      EXPECT_EQ(ldlt.factorize(lower, shift), (eigenvalues.array() < 0.0).count());
      const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(whole.rows(), -1.0, 2.0);
      EXPECT_LT((ldlt.solve(shifted * x) - x).norm(), 1e-8 * x.norm()) << diagonal << " " << shift;
    }
  }
}

TEST(SparseLdlt, TellsThatAPivotIsZero) {
  Eigen::SparseMatrix<double> lower(2, 2);
  lower.insert(0, 0) = 0.0;
  lower.insert(1, 0) = 1.0;
  lower.insert(1, 1) = 0.0;
  SparseLdlt ldlt;
  ldlt.analyze(lower);
  EXPECT_EQ(ldlt.factorize(lower, 0.0), -1);
}

TEST(Newton, ReportsThatItDidNotConverge) {
  const Sphere sphere(4);
  std::vector<Vec3> x = sphere.mesh.vertices;
  const auto result = minimize({&sphere.skin}, sphere.fixed, x, {.most_iterations = 1},
                               {sphere.mesh.triangles, Enclosure::Control::pressure, 1e5});
  EXPECT_FALSE(result.converged);
  EXPECT_GT(result.residual, 1e-9);
}

}  // namespace
}  // namespace angio::simulation::detail

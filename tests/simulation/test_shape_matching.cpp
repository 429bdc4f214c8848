#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <random>

#include "simulation/detail/shape_matching.hpp"

namespace angio::simulation::detail {
namespace {

Mat3 from_eigen(const Eigen::Matrix3d& e) {
  Mat3 m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = e(i, j);
  return m;
}

double difference(const Mat3& a, const Mat3& b) {
  double most = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) most = std::max(most, std::abs(a(i, j) - b(i, j)));
  return most;
}

Mat3 diagonal(double a, double b, double c) {
  Mat3 m;
  m(0, 0) = a;
  m(1, 1) = b;
  m(2, 2) = c;
  return m;
}

TEST(NearestRotation, RecoversTheRotationOfARotatedStretch) {
  std::mt19937 random(1);
  std::normal_distribution<double> u;
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(u(random), u(random), u(random), u(random)).normalized();
    const Mat3 r = from_eigen(q.toRotationMatrix());
    const Mat3 a = r * diagonal(1.4, 1.1, 0.6);
    EXPECT_LT(difference(nearest_rotation(a, Mat3::identity(), 200), r), 1e-8);
  }
}

TEST(NearestRotation, IsARotationEvenOfAFlatMap) {
  for (const Mat3& a : {diagonal(1, 1, 0), diagonal(1, 0, 0), Mat3{}}) {
    const Mat3 r = nearest_rotation(a, Mat3::identity());
    EXPECT_LT(difference(r * transpose(r), Mat3::identity()), 1e-12);
    EXPECT_NEAR(determinant(r), 1.0, 1e-12);
  }
}

TEST(SpectralNorm, IsTheGreatestEigenvalueByMagnitude) {
  std::mt19937 random(2);
  std::normal_distribution<double> u;
  for (int trial = 0; trial < 100; ++trial) {
    Eigen::Matrix3d e;
    for (int i = 0; i < 9; ++i) e(i) = u(random);
    e = (0.5 * (e + e.transpose())).eval();
    EXPECT_NEAR(spectral_norm(from_eigen(e)), e.eigenvalues().cwiseAbs().maxCoeff(), 1e-10);
  }
  EXPECT_NEAR(spectral_norm(diagonal(-2, -2, -2)), 2.0, 1e-12);
  EXPECT_EQ(spectral_norm(Mat3{}), 0.0);
}

TEST(PlasticFlow, StaysElasticBelowYield) {
  const PlasticFlow<double> law{0.1, 5.0, 3.0};
  EXPECT_EQ(flow(law, diagonal(1.09, 1.0, 0.95), Mat3::identity(), 0.1), Mat3::identity());
}

TEST(PlasticFlow, LeavesTheYieldStrainElasticUnderALastingStretch) {
  const PlasticFlow<double> law{0.1, 5.0, 3.0};
  Mat3 plastic = Mat3::identity();
  const double held = 1.8;
  for (int step = 0; step < 2000; ++step)
    plastic = flow(law, diagonal(held / plastic(0, 0), held / plastic(1, 1), 1.0), plastic, 0.01);
  // Flow stops when the elastic part S - I is down to yield: S^p = held / (1 + yield).
  EXPECT_NEAR(plastic(0, 0), held / 1.1, 0.005);
  EXPECT_GT(plastic(0, 0), held / 1.1 - 1e-12);
  EXPECT_NEAR(plastic(2, 2), 1.0, 1e-12);  // a widened ring does not get shorter
}

TEST(PlasticFlow, HardlyDependsOnTheTimeStep) {
  const PlasticFlow<double> law{0.05, 4.0, 3.0};
  const auto after = [&](int steps) {
    Mat3 plastic = Mat3::identity();
    for (int step = 0; step < steps; ++step)
      plastic = flow(law, diagonal(1.5 / plastic(0, 0), 1.0, 1.0), plastic, 0.2 / steps);
    return plastic(0, 0);
  };
  EXPECT_NEAR(after(8), after(64), 0.02 * (after(64) - 1.0) + 0.01);
}

TEST(PlasticFlow, IsCapped) {
  const PlasticFlow<double> law{0.0, 100.0, 0.5};
  Mat3 plastic = Mat3::identity();
  for (int step = 0; step < 20; ++step) plastic = flow(law, diagonal(2, 1, 1), plastic, 0.1);
  Mat3 strain = plastic;
  for (int i = 0; i < 3; ++i) strain(i, i) -= 1.0;
  EXPECT_NEAR(spectral_norm(strain), 0.5, 1e-9);
}

}  // namespace
}  // namespace angio::simulation::detail

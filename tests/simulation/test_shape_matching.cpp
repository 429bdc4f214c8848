#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <random>

#include "simulation/materials/shape_matching.hpp"
#include "simulation/materials/shape_modes.hpp"

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

ShapeMap<double> map_of(const Mat3& linear) {
  ShapeMap<double> map;
  map.linear = linear;
  return map;
}

// The map that is left in a shape held at stretches a, b along x, y.
Mat3 plastic_after(const PlasticFlow<double>& law, double a, double b, double time, int steps) {
  ShapeMap<double> plastic;
  for (int step = 0; step < steps; ++step) {
    const Mat3& p = plastic.linear;
    plastic = flow(law, map_of(diagonal(a / p(0, 0), b / p(1, 1), 1.0)), plastic, time / steps);
  }
  return plastic.linear;
}

TEST(PlasticFlow, StaysElasticBelowYield) {
  const PlasticFlow<double> law{0.1, 5.0, 3.0};
  const ShapeMap<double> after = flow(law, map_of(diagonal(1.09, 1.0, 0.95)), {}, 0.1);
  EXPECT_EQ(after.linear, Mat3::identity());
}

TEST(PlasticFlow, LeavesTheYieldStrainElasticUnderALastingStretch) {
  const Mat3 plastic = plastic_after({0.1, 5.0, 3.0}, 1.8, 1.8, 20.0, 2000);
  // Flow stops when the elastic part S - I is down to yield: S^p = held / (1 + yield).
  EXPECT_NEAR(plastic(0, 0), 1.8 / 1.1, 0.005);
  EXPECT_GT(plastic(0, 0), 1.8 / 1.1 - 1e-12);
  EXPECT_NEAR(plastic(2, 2), 1.0, 1e-12);  // a widened ring does not get shorter
}

TEST(PlasticFlow, SetsByTheFormulaWhateverTheStep) {
  // S^p = l - (l - 1) exp(-T c) while above yield.
  const double held = 1.5, time = 0.2, creep = 4.0;
  for (const int steps : {1, 8, 64})
    EXPECT_NEAR(plastic_after({0.05, creep, 3.0}, held, 1.0, time, steps)(0, 0),
                held - (held - 1.0) * std::exp(-time * creep), 1e-12);
}

TEST(PlasticFlow, OfAModeGoesWithThatOfTheStretch) {
  const PlasticFlow<double> law{0.05, 4.0, 3.0};
  const Vec3 held{0.1, -0.3, 0.2};
  ShapeMap<double> plastic;
  for (int step = 0; step < 10; ++step) {
    ShapeMap<double> elastic;
    elastic.modes[2] = held - plastic.modes[2];
    plastic = flow(law, elastic, plastic, 0.02);
  }
  EXPECT_LT(norm(plastic.modes[2] - (1.0 - std::exp(-0.2 * 4.0)) * held), 1e-12);
  EXPECT_EQ(plastic.linear, Mat3::identity());
}

TEST(PlasticFlow, IsCapped) {
  const PlasticFlow<double> law{0.0, 100.0, 0.5};
  ShapeMap<double> elastic = map_of(diagonal(2, 1, 1)), plastic;
  for (int step = 0; step < 20; ++step) plastic = flow(law, elastic, plastic, 0.1);
  EXPECT_NEAR(strain_size(plastic), 0.5, 1e-9);
  elastic.modes[0] = {0.0, 1.0, 0.0};
  for (int step = 0; step < 20; ++step) plastic = flow(law, elastic, plastic, 0.1);
  EXPECT_NEAR(strain_size(plastic), 0.5, 1e-9);
  EXPECT_GT(norm(plastic.modes[0]), 0.1);
}

TEST(StrainSize, IsTheGreatestSingularValueOfTheThreeByNineMap) {
  std::mt19937 random(3);
  std::normal_distribution<double> u;
  for (int trial = 0; trial < 50; ++trial) {
    Eigen::Matrix<double, 3, 3 + kShapeModes> e;
    for (Eigen::Index i = 0; i < e.size(); ++i) e(i) = u(random);
    e.leftCols<3>() = (0.5 * (e.leftCols<3>() + e.leftCols<3>().transpose())).eval();
    ShapeMap<double> map = map_of(from_eigen(Eigen::Matrix3d::Identity() + e.leftCols<3>()));
    for (int k = 0; k < kShapeModes; ++k) map.modes[k] = {e(0, 3 + k), e(1, 3 + k), e(2, 3 + k)};
    EXPECT_NEAR(strain_size(map),
                std::sqrt((e * e.transpose()).eigenvalues().cwiseAbs().maxCoeff()), 1e-9);
  }
}

TEST(QuadraticModes, AreOrthogonalToOneAnotherTheConstantAndTheLinear) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(0.5, 1.5);
  std::vector<Vec3> q;
  std::vector<double> k;
  Vec3 centre;
  double total = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double angle = 0.37 * i, r = u(random);
    q.push_back({2.0 + r * std::cos(angle), r * std::sin(angle), 0.01 * i});
    k.push_back(u(random));
    centre += k.back() * q.back();
    total += k.back();
  }
  double spread = 0.0;
  for (std::size_t i = 0; i < q.size(); ++i) {
    q[i] -= centre / total;
    spread += k[i] * norm_squared(q[i]);
  }
  const std::vector<double> modes = quadratic_modes(q, k);
  ASSERT_EQ(modes.size(), q.size() * kShapeModes);
  for (std::size_t a = 0; a < kShapeModes; ++a) {
    Vec3 by_linear;
    double by_constant = 0.0, by_mode[kShapeModes]{};
    for (std::size_t i = 0; i < q.size(); ++i) {
      const double w = k[i] * modes[i * kShapeModes + a];
      by_constant += w;
      by_linear += w * q[i];
      for (std::size_t b = 0; b < kShapeModes; ++b) by_mode[b] += w * modes[i * kShapeModes + b];
    }
    EXPECT_NEAR(by_constant, 0.0, 1e-9 * total);
    EXPECT_LT(norm(by_linear), 1e-9 * spread);
    for (std::size_t b = 0; b < kShapeModes; ++b)
      EXPECT_NEAR(by_mode[b], a == b ? spread : 0.0, 1e-9 * spread);
  }
}

TEST(QuadraticModes, AreZeroWhereNoneIsNeeded) {
  // On a line the square of x is the only one, in the corners of a triangle there is none.
  std::vector<Vec3> line;
  for (int i = -5; i <= 5; ++i) line.push_back({0.1 * i, 0.0, 0.0});
  const auto count = [](const std::vector<double>& modes) {
    int used = 0;
    for (std::size_t k = 0; k < kShapeModes; ++k)
      for (std::size_t i = k; i < modes.size(); i += kShapeModes)
        if (modes[i] != 0.0) {
          ++used;
          break;
        }
    return used;
  };
  EXPECT_EQ(count(quadratic_modes(line, std::vector<double>(line.size(), 1.0))), 1);
  EXPECT_EQ(count(quadratic_modes({{1, 0, 0}, {-1, 1, 0}, {0, -1, 0}}, {1, 1, 1})), 0);
}

}  // namespace
}  // namespace angio::simulation::detail

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <functional>
#include <random>

#include "simulation/detail/membrane.hpp"
#include "simulation/simulation.hpp"

namespace angio::simulation::detail {
namespace {

using Density = std::function<EnergyDensity<double>(double, double)>;

constexpr MooneyRivlin<double> kPolyurethane{1.031e6, 3.69e6};
constexpr double kThickness = 0.02;

Density plain() {
  return [](double i1, double i3) { return plain_energy(kPolyurethane, i1, i3); };
}
Density relaxed() {
  return [](double i1, double i3) { return relaxed_energy(kPolyurethane, i1, i3); };
}

double w(double l1, double l2) {  // Mooney-Rivlin in principal stretches [Pa]
  const double l3 = 1.0 / (l1 * l2);
  return kPolyurethane.c1 * (l1 * l1 + l2 * l2 + l3 * l3 - 3.0) +
         kPolyurethane.c2 * (1.0 / (l1 * l1) + 1.0 / (l2 * l2) + 1.0 / (l3 * l3) - 3.0);
}

// A triangle's unloaded and deformed corners.
struct Element {
  Vec3 rest[3], x[3];
};

CornerMetric<double> metric_of(const Element& t, int v) {
  return corner_metric(t.rest[v], t.rest[(v + 1) % 3], t.rest[(v + 2) % 3], kThickness);
}

double energy(const Element& t, const Density& density) {
  const CornerMetric<double> k = metric_of(t, 0);
  const Invariants<double> i = invariants(k, t.x[0] - t.x[1], t.x[2] - t.x[1]);
  return k.volume * density(i.i1, i.i3).value;
}

VertexTerm<double> term(const Element& t, int v, const Density& density) {
  const CornerMetric<double> k = metric_of(t, v);
  const Vec3 e1 = t.x[v] - t.x[(v + 1) % 3], e2 = t.x[(v + 2) % 3] - t.x[(v + 1) % 3];
  const Invariants<double> i = invariants(k, e1, e2);
  return membrane_term(k, density(i.i1, i.i3), e1, e2);
}

// A triangle stretched by l1 and l2 along turned axes in its plane, then turned in space.
Element stretched(double l1, double l2, double aspect, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  const double angle = 3.0 * u(random), c = std::cos(angle), s = std::sin(angle);
  const Vec3 a = normalized(Vec3{u(random) - 0.5, u(random) - 0.5, u(random) + 0.1});
  const Vec3 b = any_perpendicular(a), n = cross(a, b);
  Element t;
  t.rest[0] = {0, 0, 0};
  t.rest[1] = {0.4, 0.05 * u(random), 0};
  t.rest[2] = {0.2 * u(random), 0.4 * aspect, 0};
  for (int v = 0; v < 3; ++v) {
    const double p = l1 * (c * t.rest[v].x + s * t.rest[v].y);
    const double q = l2 * (-s * t.rest[v].x + c * t.rest[v].y);
    t.x[v] = p * b + q * n + Vec3{1.0, -2.0, 3.0};
  }
  return t;
}

struct Case {
  const char* what;
  double l1, l2, aspect;
  bool relaxed;
};

class MembraneTerm : public ::testing::TestWithParam<Case> {
 protected:
  Element element() const { return stretched(GetParam().l1, GetParam().l2, GetParam().aspect, 7u); }
  Density density() const { return GetParam().relaxed ? relaxed() : plain(); }
  double scale() const { return kPolyurethane.c2 * kThickness * 0.4; }  // of a force [uN]
};

TEST_P(MembraneTerm, GradientIsTheSlopeOfTheEnergy) {
  const Element t = element();
  const double h = 1e-6;
  for (int v = 0; v < 3; ++v) {
    const Vec3 gradient = term(t, v, density()).gradient;
    for (int axis = 0; axis < 3; ++axis) {
      Element up = t, down = t;
      up.x[v][axis] += h;
      down.x[v][axis] -= h;
      const double slope = (energy(up, density()) - energy(down, density())) / (2.0 * h);
      EXPECT_NEAR(gradient[axis], slope, 2e-5 * scale() / std::min(1.0, GetParam().aspect));
    }
  }
}

TEST_P(MembraneTerm, HessianIsTheGradientsSlopeWithoutItsNegativePart) {
  const Element t = element();
  const double h = 1e-6;
  for (int v = 0; v < 3; ++v) {
    Eigen::Matrix3d numeric, block;
    const VertexTerm<double> at = term(t, v, density());
    for (int axis = 0; axis < 3; ++axis) {
      Element up = t, down = t;
      up.x[v][axis] += h;
      down.x[v][axis] -= h;
      const Vec3 slope =
          (term(up, v, density()).gradient - term(down, v, density()).gradient) / (2.0 * h);
      for (int i = 0; i < 3; ++i) {
        numeric(i, axis) = slope[i];
        block(i, axis) = at.hessian(i, axis);
      }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(0.5 *
                                                               (numeric + numeric.transpose()));
    const Eigen::Matrix3d clamped = eigen.eigenvectors() *
                                    eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                                    eigen.eigenvectors().transpose();
    const double size = std::max(clamped.norm(), kPolyurethane.c2 * kThickness);
    EXPECT_LT((block - clamped).norm(), 1e-4 * size) << block << "\n\n" << clamped;
  }
}

TEST_P(MembraneTerm, ExertsNoNetForceAndNoTorque) {
  const Element t = element();
  Vec3 force, torque;
  for (int v = 0; v < 3; ++v) {
    const Vec3 gradient = term(t, v, density()).gradient;
    force += gradient;
    torque += cross(t.x[v], gradient);
  }
  EXPECT_LT(norm(force), 1e-9 * scale());
  EXPECT_LT(norm(torque), 1e-8 * scale());
}

INSTANTIATE_TEST_SUITE_P(Regimes, MembraneTerm,
                         ::testing::Values(Case{"rest", 1.0, 1.0, 1.0, false},
                                           Case{"taut", 1.3, 1.1, 1.0, false},
                                           Case{"compressed", 1.2, 0.7, 1.0, false},
                                           Case{"sliver", 1.3, 1.2, 0.02, false},
                                           Case{"equal", 1.5, 1.5, 1.0, true},
                                           Case{"relaxed_taut", 1.4, 0.95, 1.0, true},
                                           Case{"wrinkled", 1.4, 0.3, 1.0, true},
                                           Case{"wrinkled_sliver", 1.2, 0.5, 0.05, true},
                                           Case{"slack", 0.8, 0.5, 1.0, true}),
                         [](const auto& test) { return std::string(test.param.what); });

TEST(PlainEnergy, EqualsTheFormInPrincipalStretches) {
  for (const double l1 : {0.7, 1.0, 1.2, 2.5})
    for (const double l2 : {0.6, 1.0, 1.7})
      EXPECT_NEAR(plain_energy(kPolyurethane, l1 * l1 + l2 * l2, l1 * l1 * l2 * l2).value,
                  w(l1, l2), 1e-9 * kPolyurethane.c2);
}

TEST(RelaxedEnergy, IsTheLeastEnergyOverAllWrinklings) {
  for (const double l1 : {0.8, 1.1, 1.6})
    for (const double l2 : {0.2, 0.6, 0.95, 1.3}) {
      double least = 1e300;  // wrinkles let either stretch be any larger one
      for (double a = l1; a < 2.2; a += 1e-3)
        for (double b = l2; b < 2.2; b += 1e-3) least = std::min(least, w(a, b));
      EXPECT_NEAR(relaxed_energy(kPolyurethane, l1 * l1 + l2 * l2, l1 * l1 * l2 * l2).value, least,
                  2e-5 * kPolyurethane.c2)
          << l1 << " " << l2;
    }
}

TEST(RelaxedEnergy, HasNoStepInValueOrSlopeBetweenItsRegimes) {
  const double e = 1e-7;
  const auto at = [](double l1, double l2) {
    return relaxed_energy(kPolyurethane, l1 * l1 + l2 * l2, l1 * l1 * l2 * l2);
  };
  for (const double l1 : {1.05, 1.3, 2.0}) {
    const double width = 1.0 / std::sqrt(l1);
    const auto taut = at(l1, width + e), wrinkled = at(l1, width - e);
    EXPECT_TRUE(taut.taut);
    EXPECT_FALSE(wrinkled.taut);
    EXPECT_NEAR(taut.value, wrinkled.value, 1e-5 * kPolyurethane.c2);
    EXPECT_NEAR(taut.d1, wrinkled.d1, 1e-5 * kPolyurethane.c2);
    EXPECT_NEAR(taut.d3, wrinkled.d3, 1e-5 * kPolyurethane.c2);
  }
  for (const double l2 : {0.3, 0.7}) EXPECT_NEAR(at(1.0 + e, l2).d1, 0.0, 1e-4 * kPolyurethane.c2);
}

}  // namespace
}  // namespace angio::simulation::detail

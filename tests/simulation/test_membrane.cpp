#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>
#include <string>

#include "simulation/materials/membrane.hpp"
#include "testing/simulation/triangles.hpp"

namespace angio::simulation::detail {
namespace {

using namespace testing;

double w(double l1, double l2) {  // Mooney-Rivlin in principal stretches [Pa]
  const double l3 = 1.0 / (l1 * l2);
  const auto m = polyurethane<double>();
  return m.c1 * (l1 * l1 + l2 * l2 + l3 * l3 - 3.0) +
         m.c2 * (1.0 / (l1 * l1) + 1.0 / (l2 * l2) + 1.0 / (l3 * l3) - 3.0);
}

struct Case {
  const char* what;
  double l1, l2, aspect;
  bool relaxed;
};

class MembraneElement : public ::testing::TestWithParam<std::tuple<Case, bool>> {
 protected:
  const Case& shape() const { return std::get<0>(GetParam()); }
  Element<double> element() const { return stretched(shape().l1, shape().l2, shape().aspect, 7u); }
  template <class Real>
  MembraneLaw<Real> law() const {
    return law_of<Real>(shape().relaxed, std::get<1>(GetParam()));
  }
};

TEST_P(MembraneElement, GradientAndHessianAgreeWithFiniteDifferencesTo1e6) {
  const Element<double> t = element();
  const Whole<long double> numeric = differences(t, law<long double>());
  // Rest and slack have no force of their own: 1e-3 of the scale stands for it.
  const double force =
      std::max(double(numeric.gradient.norm()), 1e-3 * force_scale(shape().aspect));
  const double stiffness =
      std::max(double(numeric.hessian.norm()), 1e-3 * stiffness_scale(shape().aspect));
  for (int v = 0; v < 3; ++v) {
    const Whole<double> at = whole(t, v, law<double>());
    EXPECT_LT(double((at.gradient.cast<long double>() - numeric.gradient).norm()), 1e-6 * force);
    EXPECT_LT(double((at.hessian.cast<long double>() - numeric.hessian).norm()), 1e-6 * stiffness);
    EXPECT_TRUE(at.hessian.allFinite());
  }
}

TEST_P(MembraneElement, VertexBlockIsTheHessiansWithoutItsNegativePart) {
  const Element<double> t = element();
  for (int v = 0; v < 3; ++v) {
    const VertexTerm<double> at = term(t, v, law<double>());
    const Whole<double> all = whole(t, v, law<double>());
    const CornerMetric<double> k = metric_of(t, v);
    const Vec3 e1 = t.x[v] - t.x[(v + 1) % 3], e2 = t.x[(v + 2) % 3] - t.x[(v + 1) % 3];
    const Vec3 gradient = membrane_gradient(k, membrane_energy(law<double>(), k, e1, e2), e1, e2);
    const Eigen::Matrix3d exact = all.hessian.block<3, 3>(3 * v, 3 * v);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(exact);
    const Eigen::Matrix3d clamped = eigen.eigenvectors() *
                                    eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                                    eigen.eigenvectors().transpose();
    Eigen::Matrix3d block;
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(at.gradient[i], all.gradient(3 * v + i), 1e-10 * force_scale(shape().aspect));
      EXPECT_NEAR(at.gradient[i], gradient[i], 1e-10 * force_scale(shape().aspect));
      for (int j = 0; j < 3; ++j) block(i, j) = at.hessian(i, j);
    }
    EXPECT_LT((block - clamped).norm(),
              1e-9 * std::max(exact.norm(), stiffness_scale(shape().aspect)));
  }
}

TEST_P(MembraneElement, ExertsNoNetForceAndNoTorque) {
  const Element<double> t = element();
  Vec3 force, torque;
  for (int v = 0; v < 3; ++v) {
    const Vec3 gradient = term(t, v, law<double>()).gradient;
    force += gradient;
    torque += cross(t.x[v] - t.x[0], gradient);
  }
  EXPECT_LT(norm(force), 1e-10 * force_scale(shape().aspect));
  EXPECT_LT(norm(torque), 1e-10 * force_scale(shape().aspect));
}

TEST_P(MembraneElement, TurnsWithTheTriangle) {
  const Element<double> t = element();
  const double c = std::cos(1.1), s = std::sin(1.1);
  const auto turned = [&](const Vec3& p) {  // about z, then about x
    const Vec3 q{c * p.x - s * p.y, s * p.x + c * p.y, p.z};
    return Vec3{q.x, s * q.y - c * q.z, c * q.y + s * q.z};
  };
  Element<double> moved = t;
  for (Vec3& x : moved.x) x = turned(x);
  EXPECT_NEAR(energy(moved, law<double>()), energy(t, law<double>()),
              1e-10 * force_scale(shape().aspect));
  for (int v = 0; v < 3; ++v)
    EXPECT_LT(
        norm(term(moved, v, law<double>()).gradient - turned(term(t, v, law<double>()).gradient)),
        1e-10 * force_scale(shape().aspect));
}

TEST_P(MembraneElement, LooksTheSameFromEachCorner) {
  const Element<double> t = element();
  for (int v = 1; v < 3; ++v)
    EXPECT_NEAR(energy(t, law<double>(), v), energy(t, law<double>()),
                1e-11 * force_scale(shape().aspect));
}

INSTANTIATE_TEST_SUITE_P(
    Regimes, MembraneElement,
    ::testing::Combine(
        ::testing::Values(
            Case{"rest", 1.0, 1.0, 1.0, false}, Case{"taut", 1.3, 1.1, 1.0, false},
            Case{"equal_plain", 1.5, 1.5, 1.0, false}, Case{"compressed", 1.2, 0.7, 1.0, false},
            Case{"sliver", 1.3, 1.2, 0.02, false}, Case{"sliver_at_rest", 1.0, 1.0, 0.005, false},
            Case{"flattened", 1.0, 0.05, 1.0, false}, Case{"equal", 1.5, 1.5, 1.0, true},
            Case{"relaxed_taut", 1.4, 0.95, 1.0, true}, Case{"wrinkled", 1.4, 0.3, 1.0, true},
            Case{"wrinkled_sliver", 1.2, 0.5, 0.05, true}, Case{"slack", 0.8, 0.5, 1.0, true}),
        ::testing::Bool()),
    [](const auto& test) {
      return std::string(std::get<0>(test.param).what) +
             (std::get<1>(test.param) ? "_with_fibres" : "");
    });

TEST(Membrane, GradientAndHessianAgreeWithFiniteDifferencesInRandomStates) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> stretch(0.5, 2.5), aspect(0.05, 1.0);
  for (unsigned n = 0; n < 300; ++n) {
    const double flat = aspect(random);
    const Element<double> t = stretched(stretch(random), stretch(random), flat, n);
    const bool relaxed = n % 2 == 1, with_fibres = n % 4 > 1;
    const Whole<long double> numeric = differences(t, law_of<long double>(relaxed, with_fibres));
    const Whole<double> at = whole(t, int(n % 3), law_of<double>(relaxed, with_fibres));
    EXPECT_LE(double((at.gradient.cast<long double>() - numeric.gradient).norm()),
              1e-6 * double(numeric.gradient.norm()));
    EXPECT_LE(double((at.hessian.cast<long double>() - numeric.hessian).norm()),
              1e-6 * double(numeric.hessian.norm()));
  }
}

TEST(Membrane, ARelaxedTriangleMayCollapseToALineOrAPoint) {
  for (const double width : {0.0, 1e-9, 1e-3}) {
    const Element<double> t = stretched(1.5 * (width > 0.0 ? 1.0 : 0.0), width, 1.0, 3u);
    const Whole<double> at = whole(t, 0, law_of<double>(true, true));
    EXPECT_TRUE(at.gradient.allFinite());
    EXPECT_TRUE(at.hessian.allFinite());
    EXPECT_TRUE(std::isfinite(energy(t, law_of<double>(true, true))));
  }
}

TEST(PlainEnergy, EqualsTheFormInPrincipalStretches) {
  const auto m = polyurethane<double>();
  for (const double l1 : {0.7, 1.0, 1.2, 2.5})
    for (const double l2 : {0.6, 1.0, 1.7})
      EXPECT_NEAR(plain_energy(m, l1 * l1 + l2 * l2, l1 * l1 * l2 * l2).value, w(l1, l2),
                  1e-9 * m.c2);
}

TEST(RelaxedEnergy, IsTheLeastEnergyOverAllWrinklings) {
  const auto m = polyurethane<double>();
  for (const double l1 : {0.8, 1.1, 1.6})
    for (const double l2 : {0.2, 0.6, 0.95, 1.3}) {
      double least = 1e300;  // wrinkles let either stretch be any larger one
      for (double a = l1; a < 2.2; a += 1e-3)
        for (double b = l2; b < 2.2; b += 1e-3) least = std::min(least, w(a, b));
      EXPECT_NEAR(relaxed_energy(m, l1 * l1 + l2 * l2, l1 * l1 * l2 * l2).value, least, 2e-5 * m.c2)
          << l1 << " " << l2;
    }
}

TEST(RelaxedEnergy, HasNoStepInValueOrSlopeBetweenItsRegimes) {
  const double e = 1e-7;
  const auto m = polyurethane<double>();
  const auto at = [&](double l1, double l2) {
    return relaxed_energy(m, l1 * l1 + l2 * l2, l1 * l1 * l2 * l2);
  };
  for (const double l1 : {1.05, 1.3, 2.0}) {
    const double width = 1.0 / std::sqrt(l1);
    const auto taut = at(l1, width + e), wrinkled = at(l1, width - e);
    EXPECT_TRUE(taut.taut);
    EXPECT_FALSE(wrinkled.taut);
    EXPECT_NEAR(taut.value, wrinkled.value, 1e-5 * m.c2);
    EXPECT_NEAR(taut.d1, wrinkled.d1, 1e-5 * m.c2);
    EXPECT_NEAR(taut.d3, wrinkled.d3, 1e-5 * m.c2);
  }
  for (const double l2 : {0.3, 0.7}) EXPECT_NEAR(at(1.0 + e, l2).d1, 0.0, 1e-4 * m.c2);
}

TEST(RelaxedEnergy, CarriesNoCompressionWithFibresEither) {
  // The stress S = 2 dPsi/dC of any state pulls both ways: C is taken diagonal, the fibre turned.
  const MembraneLaw<double> law = law_of<double>(true, true);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> stretch(0.3, 2.0), angle(0.0, 3.14);
  for (int n = 0; n < 2000; ++n) {
    const double l1 = stretch(random), l2 = stretch(random), a = angle(random);
    const double f[2] = {std::cos(a), std::sin(a)};
    EnergyDensity<double> e = relaxed_energy(law.base, l1 * l1 + l2 * l2, l1 * l1 * l2 * l2);
    add_fibres(law.fibre, l1 * l1 * f[0] * f[0] + l2 * l2 * f[1] * f[1], e);
    const double p = e.d1 + e.d3 * l2 * l2 + e.d4 * f[0] * f[0], q = e.d4 * f[0] * f[1],
                 r = e.d1 + e.d3 * l1 * l1 + e.d4 * f[1] * f[1];
    EXPECT_GE(p + r, -1e-9 * law.base.c2);
    EXPECT_GE(p * r - q * q, -1e-9 * law.base.c2 * law.base.c2);
  }
}

TEST(RelaxedEnergy, IsConvexAlongEveryFoldWithFibres) {
  // Rank-one convexity, F + t a b^T: no state gains by splitting into finer folds.
  const MembraneLaw<double> law = law_of<double>(true, true);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const auto psi = [&](const Vec3& f1, const Vec3& f2) {
    const CornerMetric<double> unit{1.0, 0.0, 1.0, 1.0, 1.0, 0.8, 0.6};
    return membrane_energy(law, unit, f1, f2).value;
  };
  for (int n = 0; n < 5000; ++n) {
    const Vec3 f1{1.0 + u(random), u(random), u(random)}, f2{u(random), 1.0 + u(random), u(random)};
    const Vec3 a{u(random), u(random), u(random)};
    const double b1 = u(random), b2 = u(random);
    const double middle = psi(f1, f2);
    const double sides = 0.5 * (psi(f1 + b1 * a, f2 + b2 * a) + psi(f1 - b1 * a, f2 - b2 * a));
    EXPECT_LE(middle, sides + 1e-9 * law.base.c2);
  }
}

TEST(MembraneStress, IsThatOfThePrincipalStretches) {
  // sigma_i = l_i dw/dl_i of an incompressible sheet; fibres along the first stretch add 2 l1^2 g'.
  const auto t = stretched(1.4, 0.95, 1.0, 7u);
  const CornerMetric<double> k = metric_of(t, 1);
  const Vec3 e1 = t.x[1] - t.x[2], e2 = t.x[0] - t.x[2];
  const MembraneStress<double> at = membrane_stress(law_of<double>(false, false), k, e1, e2);
  const double h = 1e-6, scale = polyurethane<double>().c2;
  EXPECT_NEAR(at.stretch[0], 1.4, 1e-12);
  EXPECT_NEAR(at.stretch[1], 0.95, 1e-12);
  EXPECT_NEAR(at.thickness_ratio, 1.0 / (1.4 * 0.95), 1e-12);
  EXPECT_NEAR(at.energy, w(1.4, 0.95), 1e-9 * scale);
  EXPECT_NEAR(at.stress[0], 1.4 * (w(1.4 + h, 0.95) - w(1.4 - h, 0.95)) / (2 * h), 1e-6 * scale);
  EXPECT_NEAR(at.stress[1], 0.95 * (w(1.4, 0.95 + h) - w(1.4, 0.95 - h)) / (2 * h), 1e-6 * scale);

  const MembraneLaw<double> law = law_of<double>(false, true);
  const CornerMetric<double> unit{1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0};
  EnergyDensity<double> fibre;
  add_fibres(law.fibre, 1.4 * 1.4, fibre);
  const MembraneStress<double> both = membrane_stress(law, unit, Vec3{1.4, 0, 0}, Vec3{0, 0.95, 0});
  EXPECT_NEAR(both.stress[0], at.stress[0] + 2.0 * 1.4 * 1.4 * fibre.d4, 1e-9 * scale);
  EXPECT_NEAR(both.stress[1], at.stress[1], 1e-9 * scale);
}

TEST(FibreLaw, IsSmoothAcrossItsNodesAndStraightPastTheLast) {
  const FibreLaw<double> law = fibres<double>();
  const auto at = [&](double i4) {
    EnergyDensity<double> e;
    add_fibres(law, i4, e);
    return e;
  };
  EXPECT_EQ(at(0.9).value, 0.0);
  EXPECT_EQ(at(0.9).d4, 0.0);
  for (int n = 0; n < law.count; ++n) {
    const auto before = at(law.i4[n] - 1e-9), after = at(law.i4[n] + 1e-9);
    EXPECT_NEAR(before.value, after.value, 1.0);
    EXPECT_NEAR(before.d4, after.d4, 1.0);
    EXPECT_NEAR(before.d44, after.d44, 1e2);
  }
  const int last = law.count - 1;
  EXPECT_NEAR(at(law.i4[last] + 2.0).d4, law.slope[last] + 2.0 * law.curvature[last], 1e-3);
}

TEST(CornerMetric, FibresAlongAnEdgeStretchAsTheEdgeDoes) {
  const Vec3 v{0.3, 0.1, 0.0}, n{0, 0, 0}, m{0.1, 0.4, 0.0};
  const CornerMetric<double> k = corner_metric(v, n, m, kThickness, Vec3{-0.6, -0.2, 5.0});
  EXPECT_NEAR(invariants(k, v - n, m - n).i4, 1.0, 1e-14);
  EXPECT_NEAR(invariants(k, 1.7 * (v - n), m - n).i4, 1.7 * 1.7, 1e-13);
  const CornerMetric<double> normal = corner_metric(v, n, m, kThickness, Vec3{0, 0, 1});
  EXPECT_EQ(invariants(normal, v - n, m - n).i4, 0.0);
}

}  // namespace
}  // namespace angio::simulation::detail

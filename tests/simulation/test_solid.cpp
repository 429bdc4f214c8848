#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "simulation/materials/solid.hpp"
#include "simulation/materials/solid_flow.hpp"
#include "simulation/step/solid_column.hpp"
#include "simulation/step/team.hpp"

namespace angio::simulation::detail {
namespace {

using Corners = std::array<Vec3, 6>;

SolidLaw<double> neo_hookean(double ratio = 50.0) { return {.shear = 2e4, .bulk = ratio * 2e4}; }
SolidLaw<double> fibered(double share) {
  return {.shear = 5.6e4, .bulk = 2e6, .k1 = 2.6e5, .k2 = 17.0, .share = share};
}

// A solid of one wedge: unloaded and deformed corners, what a point keeps, fibres.
struct Element {
  Corners rest, x;
  SolidPoint<double> points[kWedgePoints];
  Vec3 fiber[2];
  SolidLaw<double> law;
  double volume = 0.0;
  std::array<int, 7> count = {0, 1, 2, 3, 4, 5, 6};
  int none = 0;

  SolidView<double> view(const Corners& at) const {
    SolidView<double> v;
    v.x = at.data();
    v.corners = v.patch_begin = count.data();
    v.region = v.patch = v.patch_wedges = &none;
    v.points = points;
    v.fibers = fiber;
    v.laws = &law;
    v.patch_volume = &volume;
    v.patch_bulk = &law.bulk;
    return v;
  }
  double energy(const Corners& at) const {
    const SolidView<double> v = view(at);
    return wedge_energy(v.wedge(0), at.data()) + volume * patch_energy(v, 0).value;
  }
};

// Gathers what a patch gives.
struct Sum {
  void add_gradient(int v, const Vec3& slope) {
    for (int i = 0; i < 3; ++i) gradient[3 * v + i] += slope[i];
  }
  void add_block(int i, int j, const Mat3& block) {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        hessian(3 * i + a, 3 * j + b) += block(a, b);
        if (i != j) hessian(3 * j + b, 3 * i + a) += block(a, b);
      }
  }
  Eigen::Matrix<double, 18, 1> gradient = Eigen::Matrix<double, 18, 1>::Zero();
  Eigen::Matrix<double, 18, 18> hessian = Eigen::Matrix<double, 18, 18>::Zero();
};

Mat3 rotation(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> n;
  const Eigen::Quaterniond q =
      Eigen::Quaterniond(n(random), n(random), n(random), n(random)).normalized();
  const Eigen::Matrix3d r = q.toRotationMatrix();
  Mat3 out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out(i, j) = r(i, j);
  return out;
}

struct Case {
  const char* what;
  double share;      // of the fibres' own stretch; < 0: no fibres
  double thickness;  // of the wedge, relative
  double noise;      // of the deformed corners
  double stretch;    // along z
  bool prestress;
  double squeeze = 1.0;  // along z, volume and all
};

class Wedges : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    const Case& c = GetParam();
    std::mt19937 random(11u);
    std::uniform_real_distribution<double> u(-1.0, 1.0);
    const double h = 0.3 * c.thickness;
    element_.rest = {Vec3{0, 0, 0},       Vec3{0.4, 0.05, 0},        Vec3{0.1, 0.35, 0},
                     Vec3{0.02, 0.01, h}, Vec3{0.43, 0.04, 1.1 * h}, Vec3{0.1, 0.38, 0.95 * h}};
    const Mat3 turn = rotation(3u);
    for (int a = 0; a < 6; ++a) {
      Vec3 p = element_.rest[static_cast<std::size_t>(a)];
      p.z *= c.stretch * c.squeeze;
      p.x /= std::sqrt(c.stretch);
      p.y /= std::sqrt(c.stretch);
      p += c.noise * std::min(1.0, c.thickness) * Vec3{u(random), u(random), u(random)};
      element_.x[static_cast<std::size_t>(a)] = turn * p + Vec3{1, -2, 0.5};
    }
    Mat3 s = Mat3::identity();
    if (c.prestress) s.m[0][0] = 1.05, s.m[0][1] = 0.04, s.m[1][1] = 0.97, s.m[2][1] = -0.03;
    for (int q = 0; q < kWedgePoints; ++q) {
      element_.points[q] = prestressed(make_solid_point(element_.rest.data(), q), s);
      element_.volume += element_.points[q].weight;
    }
    element_.fiber[0] = normalized(Vec3{0.6, 0.8, 0.1});
    element_.fiber[1] = normalized(Vec3{0.6, -0.8, 0.0});
    element_.law = c.share < 0.0 ? neo_hookean() : fibered(c.share);
  }

  Sum sum(const Corners& x) const {
    Sum out;
    add_patch(element_.view(x), 0, out, [](Mat3(*)[6]) {});
    return out;
  }
  Eigen::Matrix<double, 18, 1> gradient(const Corners& x) const { return sum(x).gradient; }
  Eigen::Matrix<double, 18, 18> hessian(const Corners& x) const { return sum(x).hessian; }
  Corners moved(int k, double by) const {
    Corners x = element_.x;
    x[static_cast<std::size_t>(k / 3)][k % 3] += by;
    return x;
  }
  double step() const { return 2e-5 * std::min(1.0, GetParam().thickness); }

  Element element_;
};

// Central differences of fourth order: their own error is far below the bar.
template <class Value, class Function>
Value slope(const Function& f, double h) {
  return Value((8.0 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12.0 * h));
}

TEST_P(Wedges, GradientIsTheSlopeOfTheEnergy) {
  const auto g = gradient(element_.x);
  const auto energy = [&](int k) {
    return [this, k](double by) { return element_.energy(moved(k, by)); };
  };
  // At rest the gradient is zero: the scale is then a force of 1 % strain.
  const double scale = std::max(g.norm(), 0.01 * step() / 2e-5 * hessian(element_.x).norm() * 0.3);
  for (int k = 0; k < 18; ++k)
    EXPECT_NEAR(g[k], slope<double>(energy(k), step()), 1e-6 * scale) << k;
}

TEST_P(Wedges, HessianIsTheSlopeOfTheGradientAndSymmetric) {
  const auto h = hessian(element_.x);
  EXPECT_LT((h - h.transpose()).norm(), 1e-12 * h.norm());
  for (int k = 0; k < 18; ++k) {
    const auto f = [&](double by) { return gradient(moved(k, by)); };
    const auto column = slope<Eigen::Matrix<double, 18, 1>>(f, step());
    EXPECT_LT((h.col(k) - column).norm(), 1e-6 * h.norm()) << k;
  }
}

TEST_P(Wedges, ExertNoNetForceAndNoTorque) {
  const auto g = gradient(element_.x);
  Vec3 force, torque;
  double size = 0.0;
  for (int a = 0; a < 6; ++a) {
    const Vec3 f{g[3 * a], g[3 * a + 1], g[3 * a + 2]};
    force += f;
    torque += cross(element_.x[static_cast<std::size_t>(a)], f);
    size += norm(f);
  }
  size = std::max(size, 1e-2 * hessian(element_.x).norm());
  EXPECT_LT(norm(force), 1e-10 * size);
  EXPECT_LT(norm(torque), 1e-10 * size);
}

TEST_P(Wedges, EnergyDoesNotChangeAndForcesTurnWhenTurned) {
  const Mat3 turn = rotation(5u);
  Corners x = element_.x;
  for (Vec3& p : x) p = turn * p;
  const double energy = element_.energy(element_.x);
  EXPECT_NEAR(element_.energy(x), energy, 1e-10 * std::max(energy, 1.0));
  const auto before = gradient(element_.x), after = gradient(x);
  const double size = std::max(before.norm(), 1e-2 * hessian(element_.x).norm());
  for (int a = 0; a < 6; ++a) {
    const Vec3 f = turn * Vec3{before[3 * a], before[3 * a + 1], before[3 * a + 2]};
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(after[3 * a + i], f[i], 1e-10 * size);
  }
}

struct Line {
  explicit Line(const SolidView<double>& view) {
    take_tangent(view, 0, patch_energy(view, 0).d1, place, tangent, at_rest);
  }
  // The force on a corner at other places of the corners.
  Vec3 force(const SolidView<double>& view, const Corners& x, int a) const {
    const auto at = std::size_t(a);
    Vec3 f = at_rest.constant[at];
    for (int b = 0; b < 6; ++b)
      f += in_precision<double>(tangent_block(tangent, a, b)) * (x[std::size_t(b)] - x[at]);
    const double ratio = tangent_volume(place, x.data()) / view.patch_volume[0];
    return f + volume_energy(view.laws[view.region[0]].bulk, ratio).d1 * place.by_volume[at];
  }
  WedgePlace<double> place;
  WedgeTangent<double> tangent;
  WedgeForce<double> at_rest;
};

TEST_P(Wedges, TangentIsTheForceAndItsSlopeWhereItWasTaken) {
  const SolidView<double> view = element_.view(element_.x);
  const Line line(view);
  const double size = std::max(gradient(element_.x).norm(), 1e-2 * hessian(element_.x).norm());
  const auto by_line = [&](const Corners& x) {
    Eigen::Matrix<double, 18, 1> f;
    for (int a = 0; a < 6; ++a) {
      const Vec3 force = line.force(view, x, a);
      for (int i = 0; i < 3; ++i) f[3 * a + i] = force[i];
    }
    return f;
  };
  EXPECT_LT((by_line(element_.x) - gradient(element_.x)).norm(), 1e-10 * size);
  for (int k = 0; k < 18; ++k) {
    const auto of_line = slope<Eigen::Matrix<double, 18, 1>>(
        [&](double by) { return by_line(moved(k, by)); }, step());
    const auto of_wedge = slope<Eigen::Matrix<double, 18, 1>>(
        [&](double by) { return gradient(moved(k, by)); }, step());
    EXPECT_LT((of_line - of_wedge).norm(), 1e-6 * hessian(element_.x).norm()) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(States, Wedges,
                         ::testing::Values(Case{"rest", -1.0, 1.0, 0.0, 1.0, false},
                                           Case{"random", -1.0, 1.0, 0.03, 1.0, false},
                                           Case{"sliver", -1.0, 0.02, 0.5, 1.0, false},
                                           Case{"prestressed", -1.0, 1.0, 0.02, 1.1, true},
                                           Case{"crushed", -1.0, 1.0, 0.01, 0.3, false},
                                           Case{"pressed", -1.0, 1.0, 0.01, 1.0, false, 0.5},
                                           Case{"fibers_pressed", 1.0, 1.0, 0.02, 0.9, true, 0.45},
                                           Case{"fibers_hair_taut", 1.0, 1.0, 0.0, 0.999, false},
                                           Case{"fibers_hair_slack", 1.0, 1.0, 0.0, 1.001, false},
                                           Case{"fibers_taut", 1.0, 1.0, 0.02, 0.8, false},
                                           Case{"fibers_slack", 1.0, 1.0, 0.02, 1.3, false},
                                           Case{"fibers_sliver", 1.0, 0.02, 0.5, 0.9, false},
                                           Case{"dispersed_hair_taut", 0.5, 1.0, 0.0, 0.999, false},
                                           Case{"dispersed_taut", 0.5, 1.0, 0.02, 0.85, true},
                                           Case{"dispersed_slack", 0.5, 1.0, 0.02, 1.2, false}),
                         [](const auto& test) { return std::string(test.param.what); });

TEST(PressedPoint, HasABarrierThatBeginsSmoothlyAndEndsAtNothing) {
  const double bulk = 2e6, h = 1e-5;
  EXPECT_EQ(pressed_energy(bulk, kPressed).value, 0.0);
  EXPECT_EQ(pressed_energy(bulk, 1.0).d2, 0.0);
  // Its second derivative leaves zero as -6 K (J - J0) / J0.
  EXPECT_NEAR(pressed_energy(bulk, kPressed - h).d2, 6.0 * bulk * h / kPressed, 1e-3 * bulk * h);
  for (double j = 0.02; j < kPressed; j += 0.02) {
    const auto at = [&](double by) { return pressed_energy(bulk, j + by); };
    EXPECT_NEAR(at(0).d1, slope<double>([&](double by) { return at(by).value; }, h), 1e-6 * bulk);
    EXPECT_NEAR(at(0).d2, slope<double>([&](double by) { return at(by).d1; }, h), 1e-6 * at(0).d2);
    EXPECT_LT(at(0).d1, 0.0);
    EXPECT_GT(at(0).d2, 0.0);
  }
  // The work of pressing the last tenth to nothing has no end.
  EXPECT_GT(pressed_energy(bulk, 1e-30).value, 30.0 * bulk);
  EXPECT_TRUE(std::isinf(pressed_energy(bulk, 0.0).value));
}

// Isochoric extension along a turned axis.
Mat3 extension(double stretch, unsigned seed) {
  const Mat3 turn = rotation(seed);
  Mat3 f;
  f(0, 0) = stretch;
  f(1, 1) = f(2, 2) = 1.0 / std::sqrt(stretch);
  return turn * f * transpose(rotation(seed + 1));
}

// The stretch at which an incompressible neo-Hookean bar bears a stress: G (l^2 - 1/l) = s.
double bar_stretch(double shear, double stress) {
  double low = 1.0, high = 10.0;
  for (int i = 0; i < 200; ++i) {
    const double l = 0.5 * (low + high);
    (shear * (l * l - 1.0 / l) < stress ? low : high) = l;
  }
  return low;
}

TEST(SolidFlow, IsPerfectlyPlasticInABarAsTheClosedForm) {
  SolidLaw<double> law = neo_hookean();
  law.yield = 1.5e4;
  const double elastic = bar_stretch(law.shear, law.yield);
  for (const double stretch : {1.05, 1.3, 2.0}) {
    const Mat3 f = extension(stretch, 21u);
    const FlowStep<double> step = flow_solid<double>(law, nullptr, f, 0.0);
    if (stretch <= elastic) {
      EXPECT_EQ(step.strain, 0.0);
      continue;
    }
    EXPECT_NEAR(step.strain, std::log(stretch / elastic), 1e-6);
    EXPECT_NEAR(determinant(step.growth), 1.0, 1e-12);
    // What is left is the elastic stretch, along the same axis.
    const Mat3 left = f * inverse(step.growth);
    EXPECT_NEAR(yield_stress<double>(law, nullptr, left).von_mises, law.yield, 1e-6 * law.yield);
    const Vec3 stretches = eigen_decomposition(transpose(left) * left).value;
    EXPECT_NEAR(std::max({stretches.x, stretches.y, stretches.z}), elastic * elastic, 1e-6);
  }
}

TEST(SolidFlow, CreepsTowardsTheYieldStressAsAnExponential) {
  SolidLaw<double> law = neo_hookean();
  law.yield = 1.5e4;
  law.creep = 0.8;
  const Mat3 f = extension(1.5, 23u);
  const double trial = law.shear * (1.5 * 1.5 - 1.0 / 1.5), dt = 0.3;
  const double stress = law.yield + (trial - law.yield) * std::exp(-law.creep * dt);
  const FlowStep<double> step = flow_solid<double>(law, nullptr, f, dt);
  EXPECT_NEAR(step.strain, std::log(1.5 / bar_stretch(law.shear, stress)), 1e-6);
  // Two half steps are one whole step.
  const FlowStep<double> first = flow_solid<double>(law, nullptr, f, 0.5 * dt);
  const FlowStep<double> second =
      flow_solid<double>(law, nullptr, f * inverse(first.growth), 0.5 * dt);
  EXPECT_NEAR(first.strain + second.strain, step.strain, 1e-6);
}

TEST(SolidFlow, BringsFibersToTheYieldStressAndKeepsTheVolume) {
  SolidLaw<double> law = fibered(0.5);
  law.yield = 4e5;
  const Vec3 fiber[2] = {normalized(Vec3{0.8, 0.6, 0}), normalized(Vec3{0.8, -0.6, 0})};
  for (const double stretch : {1.2, 1.5, 2.5}) {
    const Mat3 f = extension(stretch, 25u);
    if (yield_stress(law, fiber, f).von_mises <= law.yield) continue;
    const FlowStep<double> step = flow_solid(law, fiber, f, 0.0);
    EXPECT_GT(step.strain, 0.0);
    EXPECT_NEAR(determinant(step.growth), 1.0, 1e-10);
    EXPECT_NEAR(yield_stress(law, fiber, f * inverse(step.growth)).von_mises, law.yield,
                1e-6 * law.yield)
        << stretch;
  }
}

TEST(SolidLaw, IsNeoHookeanAndHolzapfelInABar) {
  // Uniaxial tension of an incompressible bar with fibres along it: s = l dPsi/dl.
  SolidLaw<double> law = fibered(1.0);
  const Vec3 fiber[2] = {{1, 0, 0}, {1, 0, 0}};
  const double l = 1.2;
  Mat3 f;
  f(0, 0) = l;
  f(1, 1) = f(2, 2) = 1.0 / std::sqrt(l);
  SolidTangent<double> tangent;
  const Mat3 p = solid_stress(law, fiber, f, tangent).p;
  const double stress = p(0, 0) * l - p(1, 1) / std::sqrt(l);
  const double over = l * l - 1.0;
  EXPECT_NEAR(
      stress,
      law.shear * (l * l - 1.0 / l) + 4.0 * law.k1 * l * l * over * std::exp(law.k2 * over * over),
      1e-9 * stress);
}

}  // namespace
}  // namespace angio::simulation::detail

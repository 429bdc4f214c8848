#include <gtest/gtest.h>

#include <random>

#include "simulation/detail/paper_contact.hpp"

/// The seed paper's projections, with its errata.
namespace angio::simulation::detail {
namespace {

TetState<double> random_tet(std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0), mass(0.1, 10.0);
  TetState<double> t;
  for (int i = 0; i < 4; ++i) {
    t.x[i] = {u(random), u(random), u(random)};
    t.before[i] = t.x[i] + 0.1 * Vec3{u(random), u(random), u(random)};
    t.inverse_mass[i] = 1.0 / mass(random);
  }
  return t;
}

Vec3 moved_mass(const TetState<double>& t, const AirProjection<double>& p) {
  Vec3 sum;
  for (int i = 0; i < 4; ++i) sum += (1.0 / t.inverse_mass[i]) * p.by[i];
  return sum;
}

TEST(PaperContact, ProjectingTheVolumeReachesItsTargetAndKeepsTheMomentum) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 100; ++trial) {
    TetState<double> t = random_tet(random);
    for (int k = 0; k < 30; ++k) {  // Newton's steps on one number
      const auto p = project_volume(t, 0.01);
      EXPECT_LT(norm(moved_mass(t, p)), 1e-12);
      for (int i = 0; i < 4; ++i) t.x[i] += p.by[i];
    }
    EXPECT_NEAR(signed_volume(t.x), 0.01, 1e-9);
  }
}

TEST(PaperContact, FrictionKeepsTheMomentumForAllKindsOfTets) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 300; ++trial) {
    const TetState<double> t = random_tet(random);
    const int side_a = 1 + trial % 3;
    const TetGap<double> gap = tet_gap(t.x, side_a);
    double a = 0.0, b = 0.0;
    for (int i = 0; i < 4; ++i) (i < side_a ? a : b) += gap.w[i];
    EXPECT_NEAR(a, 1.0, 1e-12);
    EXPECT_NEAR(b, -1.0, 1e-12);
    const auto p = project_friction(t, gap, 0.3, 0.2, 0.05);
    EXPECT_TRUE(p.acts);
    EXPECT_LT(norm(moved_mass(t, p)), 1e-12);
  }
}

// What of the relative motion friction takes back.
double taken_back(const TetState<double>& t, const TetGap<double>& gap,
                  const AirProjection<double>& p, double& slip) {
  Vec3 before, by;
  for (int i = 0; i < 4; ++i) {
    before += gap.w[i] * (t.x[i] - t.before[i]);
    by += gap.w[i] * p.by[i];
  }
  before -= dot(before, gap.normal) * gap.normal;
  slip = norm(before);
  EXPECT_NEAR(dot(by, gap.normal), 0.0, 1e-12);
  return norm(by);
}

TEST(PaperContact, FrictionHoldsUpToTheStaticLimitAndThenTakesTheKineticOne) {
  std::mt19937 random(3);
  const double mu_static = 0.3, mu_kinetic = 0.2;
  int held = 0, slid = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const TetState<double> t = random_tet(random);
    const TetGap<double> gap = tet_gap(t.x, 1 + trial % 3);
    const double normal = 0.2 * (trial % 7);
    double slip = 0.0;
    const auto p = project_friction(t, gap, mu_static, mu_kinetic, normal);
    const double taken = taken_back(t, gap, p, slip);
    const bool holds = slip <= mu_static * normal;
    EXPECT_NEAR(taken, holds ? slip : mu_kinetic * normal, 1e-12);
    ++(holds ? held : slid);
  }
  EXPECT_GT(held, 20);
  EXPECT_GT(slid, 20);
}

TEST(PaperContact, AHeldVertexDoesNotMove) {
  std::mt19937 random(4);
  TetState<double> t = random_tet(random);
  t.inverse_mass[2] = 0.0;
  EXPECT_EQ(project_volume(t, 0.0).by[2], Vec3{});
  EXPECT_EQ(norm(project_friction(t, tet_gap(t.x, 1), 0.3, 0.2, 1.0).by[2]), 0.0);
}

}  // namespace
}  // namespace angio::simulation::detail

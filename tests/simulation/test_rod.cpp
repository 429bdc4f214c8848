#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "simulation/materials/rod.hpp"

/// The guidewire's rod against closed forms of the theory of beams.
namespace angio::simulation::detail {
namespace {

constexpr double kLength = 20.0;
const RodSection<double> kSection{2e8, 1.2e7};  // EA [uN], EI [uN mm^2]: a shaft with its wire

/// A rod between held nodes, under dead loads.
struct Rod {
  std::vector<Vec3> x, bend;
  std::vector<double> rest;
  std::vector<Vec3> load;
  std::vector<int> held;
  RodSection<double> section = kSection;

  explicit Rod(std::vector<Vec3> nodes) : x(std::move(nodes)), bend(x.size()), load(x.size()) {
    for (std::size_t i = 0; i + 1 < x.size(); ++i) rest.push_back(distance(x[i], x[i + 1]));
  }

  [[nodiscard]] RodShape<double> shape() const { return {int(x.size()), rest.data(), bend.data()}; }
  [[nodiscard]] double energy(const std::vector<Vec3>& at) const {
    double value = rod_energy(shape(), section, at.data());
    for (std::size_t i = 0; i < at.size(); ++i) value -= dot(load[i], at[i]);
    return value;
  }
  [[nodiscard]] std::vector<RodRow<double>> rows() const {
    std::vector<RodRow<double>> system(x.size());
    add_rod(shape(), section, x.data(), system.data());
    for (std::size_t i = 0; i < x.size(); ++i) system[i].force += load[i];
    return system;
  }

  /// Newton steps with halving. @return the force that is left over the largest load or force
  double settle(int steps) {
    double left = 0.0;
    for (int step = 0; step < steps; ++step) {
      std::vector<RodRow<double>> system = rows();
      for (const int node : held) hold_node(node, system.data());
      left = 0.0;
      for (const RodRow<double>& row : system) left = std::max(left, norm(row.force));
      for (RodRow<double>& row : system)
        for (int k = 0; k < 3; ++k) row.own(k, k) += 1e-3;  // twist about the axis costs nothing
      solve_rod(int(x.size()), system.data());
      const double before = energy(x);
      double share = 1.0;
      for (int halving = 0; halving < 30; ++halving, share *= 0.5) {
        std::vector<Vec3> next = x;
        for (std::size_t i = 0; i < x.size(); ++i) next[i] += share * system[i].force;
        if (!(energy(next) <= before)) continue;
        x = next;
        break;
      }
    }
    return left;
  }
};

std::vector<Vec3> straight(int count, double length = kLength) {
  std::vector<Vec3> x;
  for (int i = 0; i < count; ++i) x.push_back({0.0, 0.0, length * i / (count - 1)});
  return x;
}

std::vector<Vec3> random_nodes(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-0.3, 0.3);
  std::vector<Vec3> x = straight(8, 6.0);
  for (Vec3& p : x) p += Vec3{any(random), any(random), any(random)};
  return x;
}

class RandomRod : public ::testing::TestWithParam<unsigned> {
 protected:
  RandomRod() : rod_(random_nodes(GetParam())) {
    std::mt19937 random(GetParam() + 100U);
    std::uniform_real_distribution<double> any(0.5, 1.5);
    for (double& l : rod_.rest) l *= any(random);
  }
  Rod rod_;
};

TEST_P(RandomRod, ForcesAreTheEnergysDifferences) {
  for (Vec3& bend : rod_.bend) bend = {0.2, -0.1, 0.3};
  const auto rows = rod_.rows();
  double scale = 0.0;
  for (const auto& row : rows) scale = std::max(scale, norm(row.force));
  constexpr double kStep = 1e-5;
  for (std::size_t i = 0; i < rod_.x.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      std::vector<Vec3> low = rod_.x, high = rod_.x;
      low[i][k] -= kStep;
      high[i][k] += kStep;
      const double slope = (rod_.energy(high) - rod_.energy(low)) / (2.0 * kStep);
      EXPECT_NEAR(rows[i].force[k], -slope, 1e-6 * scale) << i << ' ' << k;
    }
}

TEST_P(RandomRod, AStraightWirePushesAndTurnsNothingAsAWhole) {
  Vec3 force, torque;
  double forces = 0.0, torques = 0.0;
  const auto rows = rod_.rows();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    force += rows[i].force;
    torque += cross(rod_.x[i], rows[i].force);
    forces += norm(rows[i].force);
    torques += norm(rod_.x[i]) * norm(rows[i].force);
  }
  EXPECT_LT(norm(force), 1e-10 * forces);
  EXPECT_LT(norm(torque), 1e-10 * torques);
}

TEST_P(RandomRod, TheSystemIsSolved) {
  auto rows = rod_.rows();
  for (auto& row : rows)
    for (int k = 0; k < 3; ++k) row.own(k, k) += 1e6;
  auto solved = rows;
  solve_rod(int(rows.size()), solved.data());
  double scale = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto at = [&](std::size_t j) { return solved[j].force; };
    Vec3 sum = rows[i].own * at(i);
    if (i + 1 < rows.size()) sum += rows[i].next * at(i + 1);
    if (i + 2 < rows.size()) sum += rows[i].next_but_one * at(i + 2);
    if (i >= 1) sum += transpose(rows[i - 1].next) * at(i - 1);
    if (i >= 2) sum += transpose(rows[i - 2].next_but_one) * at(i - 2);
    scale = std::max(scale, norm(rows[i].force));
    worst = std::max(worst, norm(sum - rows[i].force));
  }
  EXPECT_LT(worst, 1e-10 * scale);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomRod, ::testing::Range(0U, 5U));

TEST(Rod, HasNoEnergyInItsOwnShape) {
  Rod rod(random_nodes(3));
  for (std::size_t i = 1; i + 1 < rod.x.size(); ++i)
    rod.bend[i] = curvature(rod.x[i] - rod.x[i - 1], rod.x[i + 1] - rod.x[i]).binormal;
  EXPECT_NEAR(rod.energy(rod.x), 0.0, 1e-12 * kSection.bend);
}

TEST(Rod, ATurnBackIsFinite) {
  const BendTerm<double> bend = bend_term<double>({0, 0, 1}, {0, 1e-9, -1}, {}, 2.0, kSection.bend);
  EXPECT_TRUE(std::isfinite(bend.energy));
  for (const Vec3& g : bend.gradient) EXPECT_TRUE(std::isfinite(norm(g)));
  EXPECT_TRUE(std::isfinite(norm(curvature<double>({0, 0, 0}, {0, 0, 1}).binormal)));
}

// EI / (2 R^2) per length. Of a polygon: 2 tan(turn / 2) for the turn, chords for arcs, in all
// 5/24 turn^2 more.
TEST(Rod, ACirclesEnergyIsThatOfItsCurvature) {
  constexpr double kRadius = 10.0;
  for (const int count : {24, 48}) {
    const double turn = kLength / kRadius / (count - 1);
    std::vector<Vec3> x;
    for (int i = 0; i < count; ++i)
      x.push_back({kRadius * std::cos(i * turn), kRadius * std::sin(i * turn), 0.0});
    const double bent = Rod(x).energy(x), length = kRadius * turn * (count - 2);
    EXPECT_NEAR(bent / (0.5 * kSection.bend * length / (kRadius * kRadius)), 1.0,
                turn * turn / 4.5);
  }
}

// The clamp is in the middle between the two nodes that are held.
TEST(Rod, ACantileverBendsAsInTheTextbook) {
  Rod rod(straight(24));
  rod.held = {0, 1};
  const double length = kLength * (1.0 - 0.5 / 23.0),
               force = 1e-3 * kSection.bend / (length * length);
  rod.load.back() = {force, 0.0, 0.0};
  EXPECT_LT(rod.settle(20), 1e-6 * force);
  EXPECT_NEAR(rod.x.back().x / (force * std::pow(length, 3) / (3.0 * kSection.bend)), 1.0, 2e-3);
}

// Mattiasson, Int. J. Numer. Methods Eng. 17 (1981) 145, by elliptic integrals: P L^2 / EI, the
// tip's drop and its way along the rod, over its length.
TEST(Rod, AFarBentCantileverIsTheElastica) {
  for (const auto& [load, drop, along] :
       {std::array{1.0, 0.30172, 0.05643}, std::array{10.0, 0.81061, 0.55500}}) {
    Rod rod(straight(48));
    rod.section.stretch *= 100.0;
    rod.held = {0, 1};
    const double length = kLength * (1.0 - 0.5 / 47.0);
    for (int step = 1; step <= 5; ++step) {
      rod.load.back() = {0.2 * step * load * kSection.bend / (length * length), 0.0, 0.0};
      rod.settle(120);
    }
    EXPECT_NEAR(rod.x.back().x / length, drop, 2e-3);
    EXPECT_NEAR((kLength - rod.x.back().z) / length, along, 2e-3);
  }
}

// Between hinges, pushed together by e L: P = pi^2 EI / L^2 (1 + e / 2) to first order in e.
TEST(Rod, BucklesAtEulersLoad) {
  Rod rod(straight(24));
  rod.section.stretch *= 100.0;
  rod.held = {0, 23};
  constexpr double kShortening = 0.01;
  rod.x.back().z -= kShortening * kLength;
  for (std::size_t i = 1; i + 1 < rod.x.size(); ++i) {
    rod.x[i].z *= 1.0 - kShortening;
    rod.x[i].y = 0.05 * std::sin(std::numbers::pi * double(i) / 23.0);
  }
  rod.settle(400);
  const double euler = std::pow(std::numbers::pi / kLength, 2) * kSection.bend;
  EXPECT_NEAR(rod.rows().back().force.z / (euler * (1.0 + 0.5 * kShortening)), 1.0, 5e-3);
}

TEST(Rod, APulledRodGrowsByHooke) {
  Rod rod(straight(24));
  rod.held = {0};
  const double force = 0.02 * kSection.stretch;
  rod.load.back() = {0.0, 0.0, force};
  EXPECT_LT(rod.settle(10), 1e-8 * force);
  EXPECT_NEAR(rod.x.back().z, 1.02 * kLength, 1e-9);
}

}  // namespace
}  // namespace angio::simulation::detail

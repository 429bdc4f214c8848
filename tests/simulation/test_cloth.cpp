#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "simulation/cloth.hpp"

namespace angio::simulation {
namespace {

ClothOptions small_cloth() {
  ClothOptions options;
  options.cells = 20;
  options.steps = 7;
  return options;
}

TEST(Cloth, PapersMeshHas2601ParticlesAnd5000Triangles) {
  ClothOptions options;
  options.stretch = 1e-3;
  options.steps = 1;
  const Cloth cloth = pull_cloth(options);
  EXPECT_EQ(cloth.rest.vertices.size(), 2601U);
  EXPECT_EQ(cloth.rest.triangles.size(), 5000U);
}

TEST(Cloth, KeepsItsVolumeAndEveryStateIsAnEquilibrium) {
  const Cloth cloth = pull_cloth(small_cloth());
  const double before = 6000.0 * 6000.0 * 1.0;
  for (const ClothState& state : cloth.states) {
    double volume = 0.0;
    for (std::size_t t = 0; t < state.thickness_mm.size(); ++t) {
      const Triangle& k = cloth.rest.triangles[t];
      const Vec3 &a = state.positions[std::size_t(k[0])], &b = state.positions[std::size_t(k[1])],
                 &c = state.positions[std::size_t(k[2])];
      volume += state.thickness_mm[t] * 0.5 * norm(cross(b - a, c - a));
    }
    EXPECT_NEAR(volume / before, 1.0, 1e-12);
    EXPECT_TRUE(state.converged);
  }
}

TEST(Cloth, HasTheEightSymmetriesOfTheSquare) {
  const ClothOptions options = small_cloth();
  const Cloth cloth = pull_cloth(options);
  const auto& x = cloth.states.back().positions;
  const int row = options.cells + 1;
  for (int j = 0; j < row; ++j)
    for (int i = 0; i < row; ++i) {
      const Vec3& p = x[std::size_t(j * row + i)];
      const Vec3& mirrored = x[std::size_t(j * row + row - 1 - i)];
      const Vec3& transposed = x[std::size_t(i * row + j)];
      EXPECT_NEAR(mirrored.x, options.side_mm - p.x, 1e-4);
      EXPECT_NEAR(mirrored.y, p.y, 1e-4);
      EXPECT_NEAR(transposed.x, p.y, 1e-4);
      EXPECT_NEAR(transposed.y, p.x, 1e-4);
    }
}

// Seed paper, section 6.1: thinner with every step, most at the corners and along the diagonals.
TEST(Cloth, ThinsWithEveryStepMostAtTheCornersAndAlongTheDiagonals) {
  const ClothOptions options = small_cloth();
  const Cloth cloth = pull_cloth(options);
  double mean_before = 2.0;
  for (const ClothState& state : cloth.states) {
    const double mean = std::accumulate(state.thickness_mm.begin(), state.thickness_mm.end(), 0.0) /
                        double(state.thickness_mm.size());
    EXPECT_LT(mean, mean_before);
    mean_before = mean;
  }
  const auto& h = cloth.states.back().thickness_mm;
  const auto cell = [&](int i, int j) {
    const auto t = std::size_t(2 * (j * options.cells + i));
    return 0.5 * (h[t] + h[t + 1]);
  };
  EXPECT_NEAR(std::min(h[0], h[1]), *std::min_element(h.begin(), h.end()), 1e-9);  // a corner
  for (int i = 1; i < options.cells / 4; ++i) EXPECT_LT(cell(i, i), cell(options.cells / 2, i));
}

TEST(Cloth, VertexBlockDescentFindsNewtonsEquilibria) {
  ClothOptions options = small_cloth();
  const Cloth newton = pull_cloth(options);
  options.solver = ClothSolver::vbd;
  const Cloth vbd = pull_cloth(options);
  ASSERT_EQ(vbd.states.size(), newton.states.size());
  for (std::size_t s = 0; s < vbd.states.size(); ++s) {
    EXPECT_TRUE(vbd.states[s].converged);
    for (std::size_t v = 0; v < newton.rest.vertices.size(); ++v)
      EXPECT_LT(distance(vbd.states[s].positions[v], newton.states[s].positions[v]),
                1e-5 * options.side_mm);
    for (std::size_t t = 0; t < newton.rest.triangles.size(); ++t)
      EXPECT_NEAR(vbd.states[s].thickness_mm[t] / newton.states[s].thickness_mm[t], 1.0, 1e-4);
  }
}

TEST(Cloth, NonsenseIsRefused) {
  ClothOptions options;
  options.cells = 7;
  EXPECT_THROW(pull_cloth(options), OptionError);
  options = {};
  options.stretch = std::nan("");
  EXPECT_THROW(pull_cloth(options), OptionError);
}

}  // namespace
}  // namespace angio::simulation

#include <gtest/gtest.h>

#include "simulation/detail/step.hpp"
#include "tests/simulation/models.hpp"

/// The GPU against the CPU; skipped where there is none.
namespace angio::simulation::detail {
namespace {

class Cuda : public ::testing::TestWithParam<Spread> {
 protected:
  void SetUp() override {
    if (!has_cuda_device()) GTEST_SKIP() << "no GPU";
    model_.balloon = testing::closed_tube(10.0, 26, 20, [](double) { return 0.5; });
    model_.balloon_rest = model_.balloon.vertices;
    model_.balloon_fixed.assign(model_.balloon.vertices.size(), 0);
    model_.balloon_fixed.back() = model_.balloon_fixed.end()[-2] = 1;
    options_.balloon.name = "polyurethane";
    options_.balloon.wall_mm = 0.04;
    options_.inflation.peak_pressure_atm = 4.0;
  }

  std::vector<State> frames(StepSolver& solver, const Scene& scene) const {
    const double volume = balloon_volume(scene, scene.start);
    std::vector<State> states;
    solver.run(Inflator(options_, volume, 1.3 * volume),
               [&](int, const State& state) { states.push_back(state); });
    return states;
  }

  SimulationModel model_;
  SimulationOptions options_;
};

TEST_P(Cuda, FreeBalloonIsTheCpusWithinAThousandthOfAMillimetre) {
  const Scene scene = make_scene(model_, options_);
  const auto cpu = frames(*make_cpu_solver(scene, options_, Precision::single), scene);
  const auto gpu = frames(*make_cuda_solver(scene, options_, Precision::single, GetParam()), scene);
  ASSERT_EQ(cpu.size(), gpu.size());
  for (std::size_t f = 0; f < cpu.size(); ++f)
    for (std::size_t v = 0; v < cpu[f].x.size(); ++v)
      EXPECT_LT(distance(cpu[f].x[v], gpu[f].x[v]), 1e-3) << f;
}

TEST_P(Cuda, TwoRunsGiveTheSameBits) {
  const Scene scene = make_scene(model_, options_);
  const auto one = frames(*make_cuda_solver(scene, options_, Precision::single, GetParam()), scene);
  const auto two = frames(*make_cuda_solver(scene, options_, Precision::single, GetParam()), scene);
  for (std::size_t f = 0; f < one.size(); ++f) EXPECT_EQ(one[f].x, two[f].x) << f;
}

INSTANTIATE_TEST_SUITE_P(Spreads, Cuda, ::testing::Values(Spread::block, Spread::grid));

}  // namespace
}  // namespace angio::simulation::detail

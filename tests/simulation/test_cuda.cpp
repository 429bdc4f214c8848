#include <gtest/gtest.h>

#include "simulation/detail/measure.hpp"
#include "simulation/detail/step.hpp"
#include "tests/simulation/folded.hpp"
#include "tests/simulation/matched.hpp"

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

// A balloon that is blown up against a wall and let go, with the air mesh between them.
std::vector<SimulationFrame> frames_in_a_vessel(Backend backend) {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.balloon.wall_mm = 0.04;
  options.inflation.peak_pressure_atm = 4.0;
  options.inflation.inflate_s = options.inflation.deflate_s = 0.5;
  options.inflation.hold_s = options.inflation.rest_s = 0.1;
  options.backend = backend;
  std::vector<SimulationFrame> frames;
  simulate(testing::model_in_a_bag(0.5, 0.62), options,
           [&](const SimulationFrame& frame) { frames.push_back(frame); });
  return frames;
}

TEST(CudaInAVessel, BalloonWallAndAirAreTheCpus) {
  if (!has_cuda_device()) GTEST_SKIP() << "no GPU";
  const auto cpu = frames_in_a_vessel(Backend::cpu), gpu = frames_in_a_vessel(Backend::cuda);
  ASSERT_EQ(cpu.size(), gpu.size());
  int contacts = 0;
  for (std::size_t f = 0; f < cpu.size(); ++f) {
    for (std::size_t v = 0; v < cpu[f].balloon.size(); ++v)
      EXPECT_LT(distance(cpu[f].balloon[v], gpu[f].balloon[v]), 1e-3) << f;
    for (std::size_t v = 0; v < cpu[f].wall.size(); ++v)
      EXPECT_LT(distance(cpu[f].wall[v], gpu[f].wall[v]), 1e-3) << f;
    EXPECT_GT(gpu[f].air_tet_count, 0) << f;
    EXPECT_EQ(gpu[f].inverted_air_tet_count, 0) << f;
    EXPECT_EQ(gpu[f].max_penetration_mm, 0.0) << f;
    contacts = std::max(contacts, gpu[f].contact_count);
  }
  EXPECT_GT(contacts, 0);
}

TEST(CudaInAVessel, TwoRunsGiveTheSameBits) {
  if (!has_cuda_device()) GTEST_SKIP() << "no GPU";
  const auto one = frames_in_a_vessel(Backend::cuda), two = frames_in_a_vessel(Backend::cuda);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t f = 0; f < one.size(); ++f) {
    EXPECT_EQ(one[f].balloon, two[f].balloon) << f;
    EXPECT_EQ(one[f].wall, two[f].wall) << f;
  }
}

TEST(CudaFolds, DoNotPassThroughEachOther) {
  if (!has_cuda_device()) GTEST_SKIP() << "no GPU";
  const SimulationModel model = testing::folded_model({});
  SimulationOptions options;
  options.self_contact = true;
  options.backend = Backend::cuda;
  options.inflation.inflate_s = 0.3;
  options.inflation.hold_s = 0.05;
  options.inflation.deflate_s = 0.1;
  options.inflation.rest_s = 0.0;
  const SimulationSummary summary = simulate(model, options, [&](const SimulationFrame& frame) {
    EXPECT_EQ(self_crossing_count(model.balloon.triangles, frame.balloon), 0) << frame.frame;
  });
  EXPECT_GT(summary.peak_pressure_atm, 0.9 * options.inflation.peak_pressure_atm);
}

INSTANTIATE_TEST_SUITE_P(Spreads, Cuda, ::testing::Values(Spread::block, Spread::grid));

}  // namespace
}  // namespace angio::simulation::detail

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "simulation/backends/step_solver.hpp"
#include "testing/cuda/lost_device.hpp"
#include "testing/simulation/matched.hpp"

/// A GPU that is lost on the way. Nothing in this process can use it afterwards: CTest runs each
/// test in a process of its own.
namespace angio::simulation {
namespace {

using ::testing::HasSubstr;

constexpr int kLostAt = 5;

SimulationSummary run_and_lose(Backend backend, std::vector<SimulationFrame>& frames) {
  return simulate(testing::model_in_a_bag(0.5, 0.62), testing::rubber_options(backend),
                  [&](const SimulationFrame& frame) {
                    frames.push_back(frame);
                    if (frame.frame == kLostAt && backend != Backend::cpu)
                      angio::testing::lose_device();
                  });
}

TEST(LostDevice, EndsARunOnCudaWithOneClearLine) {
  if (!detail::has_cuda_device()) GTEST_SKIP() << "no GPU";
  std::vector<SimulationFrame> frames;
  try {
    run_and_lose(Backend::cuda, frames);
    FAIL() << "the run has gone on";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::unavailable);
    EXPECT_THAT(error.what(), HasSubstr("the GPU failed while"));
    EXPECT_THAT(error.what(), HasSubstr("--backend cpu"));
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

TEST(LostDevice, LeavesAnAutomaticRunToTheCpuWithANotice) {
  if (!detail::has_cuda_device()) GTEST_SKIP() << "no GPU";
  std::vector<SimulationFrame> frames, cpu;
  const SimulationSummary summary = run_and_lose(Backend::automatic, frames);
  run_and_lose(Backend::cpu, cpu);
  EXPECT_EQ(summary.backend, "cpu");
  EXPECT_EQ(summary.frame_count, int(cpu.size()));
  ASSERT_FALSE(summary.warnings.empty());
  EXPECT_THAT(summary.warnings[0], HasSubstr("the CPU was used instead: the GPU failed while"));
  ASSERT_EQ(frames.size(), cpu.size());
  for (std::size_t f = 0; f < frames.size(); ++f) {
    EXPECT_EQ(frames[f].frame, int(f));  // each once
    for (std::size_t v = 0; v < frames[f].balloon.size(); ++v)
      ASSERT_LT(distance(frames[f].balloon[v], cpu[f].balloon[v]), 1e-3) << f;
  }
  EXPECT_EQ(frames.back().balloon, cpu.back().balloon);
}

}  // namespace
}  // namespace angio::simulation

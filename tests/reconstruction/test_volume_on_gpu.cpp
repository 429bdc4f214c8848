#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "reconstruction/detail/frame_filter.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction {
namespace {

using angiogram::ConeBeamFrame;
using ::testing::HasSubstr;
using tests::Ball;
using tests::PicturesOfBalls;
using tests::turn;

const std::vector<Ball> kTwoBalls = {{{3.0, -4.0, 2.0}, 5.0, 0.02}, {{-6.0, 5.0, -3.0}, 2.5, 0.04}};
const std::vector<Ball> kBody = {{{0, 0, 0}, 60.0, 0.02}, {{4.0, 0, 0}, 4.0, -0.02}};

struct Both {
  Reconstruction cpu, gpu;
};
Both on_both(RotationalRun run, ReconstructionOptions options = {}) {
  options.calibrate = false;
  options.backend = Backend::cpu;
  Both both;
  both.cpu = reconstruct_volume(run, options);
  options.backend = Backend::cuda;
  both.gpu = reconstruct_volume(run, options);
  return both;
}

/// The largest step between neighbouring samples, summed over filtered frames.
double sum_of_steps(const RotationalRun& run, double air) {
  using namespace detail;
  const Orbit orbit = fit_orbit(run.frames);
  const VolumeTask task{run, orbit, plane_grid(run.frames, orbit),
                        {},  air,   FilterWindow::shepp_logan};
  FrameFilter filter(task);
  double sum = 0.0;
  for (int f = 0; f < int(run.frames.size()); ++f) {
    const FilteredFrames one = filter.filter(f, 1);
    double largest = 0.0;
    for (std::size_t i = 0; i < one.values.size(); ++i) {
      const std::size_t line = std::size_t(one.v_count);
      if (i % line != 0)
        largest = std::max(largest, double(std::abs(one.values[i] - one.values[i - 1])));
      if (i >= line)
        largest = std::max(largest, double(std::abs(one.values[i] - one.values[i - line])));
    }
    sum += largest;
  }
  return sum;
}

/// The texture's weights along u and v have 8 bits: each is off by 2^-9 at most. Nearer to the
/// source values weigh up to 1.1 here; single precision is well under the rest of it.
void expect_same(const Both& both, const RotationalRun& run) {
  ASSERT_EQ(both.gpu.volume.geometry, both.cpu.volume.geometry);
  EXPECT_EQ(both.gpu.backend, "cuda");
  EXPECT_FALSE(both.gpu.device.empty());
  EXPECT_GT(both.gpu.gpu.projecting, 0.0);
  EXPECT_EQ(both.gpu.quality.truncated_percent, both.cpu.quality.truncated_percent);
  const double air = run.masks ? 1.0 : both.cpu.quality.unattenuated;
  const double bound = 1.1 * 2.0 * std::pow(2.0, -9) * sum_of_steps(run, air);
  double squares = 0.0, most = 0.0, least = 0.0;
  for (std::size_t v = 0; v < both.cpu.volume.values.size(); ++v) {
    const double off = double(both.gpu.volume.values[v]) - double(both.cpu.volume.values[v]);
    ASSERT_LT(std::abs(off), bound) << v;
    squares += off * off;
    most = std::max(most, double(both.cpu.volume.values[v]));
    least = std::min(least, double(both.cpu.volume.values[v]));
  }
  // They fall to both sides, so that they mostly cancel.
  EXPECT_LT(std::sqrt(squares / double(both.cpu.volume.values.size())), 5e-4 * (most - least));
}

class VolumeOnGpu : public ::testing::Test {
 protected:
  void SetUp() override {
    if (detail::gpu_name().empty()) GTEST_SKIP() << "no GPU";
  }
};

RotationalRun run_of(const std::vector<ConeBeamFrame>& frames, const PicturesOfBalls& pictures) {
  RotationalRun run;
  run.frames = frames;
  run.pictures = &pictures;
  return run;
}

TEST_F(VolumeOnGpu, IsTheCpus) {
  const auto frames = turn(180, -100.0, 100.0);
  const PicturesOfBalls pictures(frames, kTwoBalls);
  const RotationalRun run = run_of(frames, pictures);
  expect_same(on_both(run), run);
}

TEST_F(VolumeOnGpu, OfADetectorThatIsShiftedAndTurnedIsTheCpus) {
  auto frames = turn(67, -100.0, 100.0, 110, 81);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const double roll = 0.01 * std::sin(0.3 * double(f)), shift = std::cos(0.7 * double(f));
    const Vec3 c = frames[f].column_step, r = frames[f].row_step;
    frames[f].column_step = std::cos(roll) * c + std::sin(roll) * r;
    frames[f].row_step = std::cos(roll) * r - std::sin(roll) * c;
    frames[f].first_pixel += shift * c - 0.5 * shift * r;
  }
  const PicturesOfBalls pictures(frames, kTwoBalls);
  const RotationalRun run = run_of(frames, pictures);
  expect_same(on_both(run), run);
}

TEST_F(VolumeOnGpu, OfABodyWiderThanTheDetectorIsTheCpus) {
  const auto frames = turn(90, -100.0, 100.0);
  const PicturesOfBalls pictures(frames, kBody);
  const RotationalRun run = run_of(frames, pictures);
  ReconstructionOptions options;
  options.air = 10000.0;
  expect_same(on_both(run, options), run);
}

TEST_F(VolumeOnGpu, WithMasksAndAShutterIsTheCpus) {
  const auto frames = turn(90, -100.0, 100.0);
  const PicturesOfBalls masks(frames, {kTwoBalls[0]}), pictures(frames, kTwoBalls);
  RotationalRun run = run_of(frames, pictures);
  run.masks = &masks;
  run.open_field = {2, 93, 3, 60};
  expect_same(on_both(run), run);
}

TEST_F(VolumeOnGpu, OfLogarithmicPixelsIsTheCpus) {
  const auto frames = turn(60, -100.0, 100.0);
  const PicturesOfBalls pictures(frames, kTwoBalls, 2.0);
  RotationalRun run = run_of(frames, pictures);
  run.relation = PixelRelation::logarithmic;
  expect_same(on_both(run), run);
}

TEST_F(VolumeOnGpu, ComesTheSameTwice) {
  const auto frames = turn(60, -100.0, 100.0);
  const PicturesOfBalls pictures(frames, kTwoBalls);
  ReconstructionOptions options;
  options.backend = Backend::cuda;
  const RotationalRun run = run_of(frames, pictures);
  EXPECT_EQ(reconstruct_volume(run, options).volume.values,
            reconstruct_volume(run, options).volume.values);
}

TEST(VolumeWithoutAGpu, IsLeftToTheCpuOrRefused) {
  if (!detail::gpu_name().empty()) GTEST_SKIP() << "there is a GPU";
  const auto frames = turn(30, -100.0, 100.0);
  const PicturesOfBalls pictures(frames, kTwoBalls);
  ReconstructionOptions options;
  const Reconstruction result = reconstruct_volume(run_of(frames, pictures), options);
  EXPECT_EQ(result.backend, "cpu");
  EXPECT_TRUE(result.device.empty());
  options.backend = Backend::cuda;
  try {
    reconstruct_volume(run_of(frames, pictures), options);
    FAIL() << "it went on without a GPU";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::unavailable);
    EXPECT_THAT(error.what(), HasSubstr("--backend cpu"));
  }
}

}  // namespace
}  // namespace angio::reconstruction

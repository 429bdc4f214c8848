#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "reconstruction/detail/volume_task.hpp"
#include "testing/cuda/lost_device.hpp"
#include "tests/reconstruction/turning_balls.hpp"

/// A GPU that is lost while frames are read. Nothing in this process can use it afterwards: CTest
/// runs each test in a process of its own.
namespace angio::reconstruction {
namespace {

using ::testing::HasSubstr;
using tests::PicturesOfBalls;
using tests::turn;

class LosingPictures : public FrameReader {
 public:
  explicit LosingPictures(const FrameReader& pictures) : pictures_(pictures) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    if (first > 30 && count > 1) angio::testing::lose_device();
    return pictures_.read(first, count);
  }

 private:
  const FrameReader& pictures_;
};

Reconstruction lose(Backend backend) {
  const auto frames = turn(90, -100.0, 100.0);
  const PicturesOfBalls balls(frames, {{{3.0, -4.0, 2.0}, 5.0, 0.02}});
  const LosingPictures pictures(balls);
  RotationalRun run;
  run.frames = frames;
  run.pictures = backend == Backend::cpu ? static_cast<const FrameReader*>(&balls) : &pictures;
  ReconstructionOptions options;
  options.backend = backend;
  return reconstruct_volume(run, options);
}

TEST(LostGpu, EndsAVolumeOnCudaWithOneClearLine) {
  if (detail::gpu_name().empty()) GTEST_SKIP() << "no GPU";
  try {
    lose(Backend::cuda);
    FAIL() << "the work has gone on";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::unavailable);
    EXPECT_THAT(error.what(), HasSubstr("the GPU failed while"));
    EXPECT_THAT(error.what(), HasSubstr("--backend cpu"));
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

TEST(LostGpu, LeavesAnAutomaticVolumeToTheCpuWithANotice) {
  if (detail::gpu_name().empty()) GTEST_SKIP() << "no GPU";
  const Reconstruction result = lose(Backend::automatic), cpu = lose(Backend::cpu);
  EXPECT_EQ(result.backend, "cpu");
  EXPECT_EQ(result.volume.values, cpu.volume.values);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_THAT(result.warnings[0], HasSubstr("the CPU was used instead: the GPU failed while"));
}

}  // namespace
}  // namespace angio::reconstruction

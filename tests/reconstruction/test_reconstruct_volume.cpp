#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/error.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction {
namespace {

using testing::HasSubstr;
using tests::Ball;
using tests::PicturesOfBalls;
using tests::turn;

const std::vector<Ball> kBalls = {{{3.0, -4.0, 2.0}, 5.0, 0.02}, {{-6.0, 5.0, -3.0}, 2.5, 0.04}};

Reconstruction reconstruct(const std::vector<angiogram::ConeBeamFrame>& frames,
                           const std::vector<Ball>& balls = kBalls,
                           const ReconstructionOptions& options = {}) {
  const PicturesOfBalls pictures(frames, balls);
  RotationalRun run;
  run.frames = frames;
  run.pictures = &pictures;
  return reconstruct_volume(run, options);
}

double at(const Reconstruction& result, const Vec3& point) {
  return interpolate(result.volume, point);
}

/// The mean over places within `reach` of a ball's middle.
double mean_in(const Reconstruction& result, const Vec3& middle, double reach) {
  double sum = 0.0;
  int count = 0;
  for (double x = -reach; x <= reach; x += 0.5)
    for (double y = -reach; y <= reach; y += 0.5)
      for (double z = -reach; z <= reach; z += 0.5)
        if (x * x + y * y + z * z <= reach * reach) {
          sum += at(result, middle + Vec3{x, y, z});
          ++count;
        }
  return sum / count;
}

void expect_balls(const Reconstruction& result, double tolerance) {
  for (const Ball& ball : kBalls)
    EXPECT_NEAR(mean_in(result, ball.middle, ball.radius - 1.2), ball.attenuation,
                tolerance * ball.attenuation);
  EXPECT_NEAR(mean_in(result, {-5.0, -8.0, 0.0}, 2.0), 0.0, 0.001);
}

TEST(ReconstructVolume, GivesBallsTheirAttenuationInTheirPlace) {
  expect_balls(reconstruct(turn(180, -100.0, 100.0)), 0.01);
}

TEST(ReconstructVolume, OfAFullTurnAndMoreGivesTheSame) {
  expect_balls(reconstruct(turn(240, 0.0, 358.5)), 0.01);
  expect_balls(reconstruct(turn(260, 0.0, 388.5)), 0.01);
}

TEST(ReconstructVolume, DoesNotDependOnTheSenseOfTheTurn) {
  const Reconstruction a = reconstruct(turn(120, -100.0, 100.0)),
                       b = reconstruct(turn(120, 100.0, -100.0));
  for (std::size_t v = 0; v < a.volume.values.size(); v += 97)
    ASSERT_NEAR(a.volume.values[v], b.volume.values[v], 1e-5);
}

TEST(ReconstructVolume, TakesARunThatIsTiltedToTheHead) {
  expect_balls(reconstruct(turn(180, -100.0, 100.0, 96, 64, 8.0)), 0.02);
}

TEST(ReconstructVolume, TakesADetectorThatIsShiftedAndTurned) {
  auto frames = turn(180, -100.0, 100.0, 110, 80);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const double roll = 0.01 * std::sin(0.3 * double(f)), shift = std::cos(0.7 * double(f));
    const Vec3 c = frames[f].column_step, r = frames[f].row_step;
    frames[f].column_step = std::cos(roll) * c + std::sin(roll) * r;
    frames[f].row_step = std::cos(roll) * r - std::sin(roll) * c;
    frames[f].first_pixel += shift * c - 0.5 * shift * r;
  }
  expect_balls(reconstruct(frames), 0.015);
}

/// The same frame with its picture turned by a quarter.
angiogram::ConeBeamFrame turned_by_a_quarter(const angiogram::ConeBeamFrame& frame) {
  return {frame.source,
          frame.place(0, frame.rows - 1),
          -1.0 * frame.row_step,
          frame.column_step,
          frame.rows,
          frame.columns};
}

TEST(ReconstructVolume, TakesPicturesThatAreTurnedByQuarters) {
  auto frames = turn(180, -100.0, 100.0);
  for (int quarter = 1; quarter < 4; ++quarter) {
    for (auto& frame : frames) frame = turned_by_a_quarter(frame);
    expect_balls(reconstruct(frames), 0.01);
  }
}

TEST(ReconstructVolume, TakesATurnAboutTheAxisFromLeftToRight) {
  auto frames = turn(180, 0.0, 0.0);
  for (std::size_t f = 0; f < frames.size(); ++f)
    frames[f] = turn(2, 0.0, 0.0, 96, 64, -100.0 + 200.0 * double(f) / 179.0).front();
  expect_balls(reconstruct(frames), 0.02);
}

TEST(ReconstructVolume, WithMasksLeavesOutWhatIsInBoth) {
  const auto frames = turn(180, -100.0, 100.0);
  const std::vector<Ball> both = {{{8.0, 8.0, 0.0}, 4.0, 0.05}};
  std::vector<Ball> all = both;
  all.insert(all.end(), kBalls.begin(), kBalls.end());
  const PicturesOfBalls pictures(frames, all), masks(frames, both);
  RotationalRun run;
  run.frames = frames;
  run.pictures = &pictures;
  run.masks = &masks;
  const Reconstruction result = reconstruct_volume(run, {});
  expect_balls(result, 0.015);
  EXPECT_NEAR(mean_in(result, both[0].middle, 3.0), 0.0, 0.0006);
}

TEST(ReconstructVolume, OfABodyWiderThanTheDetectorKeepsItsLevel) {
  // Water of 60 mm around the field of 24; a hole of nothing in it.
  const std::vector<Ball> body = {{{0, 0, 0}, 60.0, 0.02}, {{4.0, 0, 0}, 4.0, -0.02}};
  ReconstructionOptions options;
  options.air = 10000.0;
  const Reconstruction result = reconstruct(turn(180, -100.0, 100.0), body, options);
  EXPECT_GT(result.quality.truncated_percent, 99.0);
  EXPECT_NEAR(mean_in(result, {-8.0, 0.0, 0.0}, 2.0), 0.02, 0.003);
  EXPECT_NEAR(mean_in(result, {-8.0, 0.0, 0.0}, 2.0) - mean_in(result, {4.0, 0, 0}, 2.5), 0.02,
              0.0015);
}

TEST(ReconstructVolume, OfFewDegreesSaysWhatIsMissing) {
  const Reconstruction result = reconstruct(turn(90, 0.0, 120.0));
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_THAT(result.warnings.front(), HasSubstr("121 degrees"));
  EXPECT_THAT(result.doubt, HasSubstr("121 of the"));
  EXPECT_TRUE(reconstruct(turn(120, -85.0, 85.0)).doubt.empty());
}

TEST(ReconstructVolume, RefusesFramesOfAir) {
  try {
    reconstruct(turn(60, -100.0, 100.0), {});
    FAIL() << "frames of air were taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("frames of air"));
  }
}

/// A detector in a bare beam.
class NoisyAir : public FrameReader {
 public:
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::mt19937 random{std::uint32_t(first)};
    std::normal_distribution<float> pixel(10000.0F, 50.0F);
    std::vector<float> pixels(std::size_t(count) * 96 * 64);
    for (float& value : pixels) value = std::round(pixel(random));
    return pixels;
  }
};

TEST(ReconstructVolume, RefusesFramesOfNoiseAlone) {
  const NoisyAir air;
  RotationalRun run;
  run.frames = turn(60, -100.0, 100.0);
  run.pictures = &air;
  try {
    reconstruct_volume(run, {});
    FAIL() << "noise was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("nothing but noise"));
  }
}

/// Counts how many frames are asked for at once.
class CountingPictures : public FrameReader {
 public:
  explicit CountingPictures(const FrameReader& pictures) : pictures_(pictures) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    most_ = std::max(most_, count);
    return pictures_.read(first, count);
  }
  [[nodiscard]] std::vector<float> read_some(const std::vector<int>& frames) const override {
    most_ = std::max(most_, int(frames.size()));
    return pictures_.read_some(frames);
  }
  [[nodiscard]] int most() const { return most_; }

 private:
  const FrameReader& pictures_;
  mutable int most_ = 0;
};

TEST(ReconstructVolume, HoldsSomeFramesAtATime) {
  const auto frames = turn(150, -100.0, 100.0);
  const PicturesOfBalls balls(frames, kBalls);
  const CountingPictures pictures(balls);
  RotationalRun run;
  run.frames = frames;
  run.pictures = &pictures;
  reconstruct_volume(run, {});
  EXPECT_LE(pictures.most(), 32);
}

TEST(RunForecast, SaysWhatTheVolumeThenIs) {
  const auto frames = turn(120, -100.0, 100.0);
  const RunForecast forecast = forecast_run(frames, false, {});
  const Reconstruction result = reconstruct(frames);
  EXPECT_EQ(forecast.grid.size, result.volume.geometry.size);
  EXPECT_EQ(forecast.grid.spacing.x, result.volume.geometry.spacing.x);
  EXPECT_EQ(forecast.quality.arc_degrees, result.quality.arc_degrees);
  EXPECT_FALSE(forecast.is_sparse);
  EXPECT_NEAR(forecast.radius_error_mm, 0.05, 1e-3);  // a tenth of 0.5 mm
}

TEST(RunForecast, ExpectsLessOfFewFramesAndNothingOfAShortArc) {
  const RunForecast sparse = forecast_run(turn(19, -100.0, 100.0), false, {});
  EXPECT_TRUE(sparse.is_sparse);
  EXPECT_NEAR(sparse.radius_error_mm, 0.1, 2e-3);
  EXPECT_TRUE(std::isnan(forecast_run(turn(120, 0.0, 120.0), false, {}).radius_error_mm));
  EXPECT_THROW(forecast_run(turn(20, 0.0, 20.0), false, {}), InputError);
}

TEST(ReconstructVolume, GivesVoxelsTheSizeThatIsAskedFor) {
  ReconstructionOptions options;
  options.voxel_mm = 1.25;
  const Reconstruction result = reconstruct(turn(60, -100.0, 100.0), kBalls, options);
  EXPECT_EQ(result.volume.geometry.spacing.x, 1.25);
  EXPECT_NEAR(result.volume.geometry.size[0] * 1.25, 2.0 * result.quality.field_radius_mm, 1.25);
}

TEST(ReconstructionOptions, OutOfRangeAreRefused) {
  ReconstructionOptions options;
  options.voxel_mm = 0.001;
  EXPECT_THROW(options.validate(), OptionError);
  options = {};
  options.largest_side = 4;
  EXPECT_THROW(options.validate(), OptionError);
}

}  // namespace
}  // namespace angio::reconstruction

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/error.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/gating.hpp"
#include "reconstruction/detail/heart_signal.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction::detail {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;
using tests::Ball;
using tests::PicturesOfBalls;
using tests::turn;

constexpr double kFrameTime = 0.033;

std::vector<double> times(int count) {
  std::vector<double> seconds;
  for (int f = 0; f < count; ++f) seconds.push_back(kFrameTime * f);
  return seconds;
}

TEST(Gating, TellsPhasesBetweenRWaves) {
  EXPECT_THAT(cardiac_phases({1.0, 1.25, 1.9, 2.0, 2.5}, {1.0, 2.0, 4.0}),
              ElementsAre(0.0, 0.25, DoubleNear(0.9, 1e-12), 0.0, 0.25));
}

TEST(Gating, GoesOnWithTheMedianBeatBeyondTheLastRWave) {
  const auto phases = cardiac_phases({0.5, 5.3}, {1.0, 2.0, 3.0, 5.0});
  EXPECT_NEAR(phases[0], 0.5, 1e-12);
  EXPECT_NEAR(phases[1], 0.3, 1e-12);
}

TEST(Gating, TakesFramesAroundTheCircle) {
  EXPECT_THAT(frames_of_phase({0.0, 0.06, 0.5, 0.96, 0.89}, 0.0, 0.2), ElementsAre(0, 1, 3));
}

double beating(double phase) {
  return std::cos(2.0 * units::kPi * phase) + 0.4 * std::sin(4.0 * units::kPi * phase);
}

TEST(HeartSignal, FindsTheRateOfABeat) {
  const std::vector<double> at = times(133);
  std::vector<double> signal, flat;
  for (std::size_t n = 0; n < at.size(); ++n) {
    const double slow = 4.0 * std::cos(1.3 * at[n]), noise = 0.1 * std::sin(17.0 * double(n * n));
    signal.push_back(slow + noise + 2.0 * beating(1.25 * at[n]));
    flat.push_back(slow + noise);
  }
  const Beat beat = find_beat(signal, at);
  EXPECT_NEAR(beat.rate_per_s, 1.25, 0.02);
  EXPECT_NEAR(beat.amplitude_mm, 2.0 * std::sqrt(0.5 * (1.0 + 0.16)), 0.05);
  EXPECT_GT(beat.f_ratio, 100.0);
  EXPECT_LT(find_beat(flat, at).amplitude_mm, 0.1);
}

TEST(HeartSignal, AnEvenWaveBeatsAtItsRateOrAPartOfIt) {
  const std::vector<double> at = times(133);
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (const double per_minute : {60.0, 75.0, 90.0, 112.0, 150.0})
    for (int trial = 0; trial < 5; ++trial) {
      std::vector<double> signal;
      double wander = 0.0;
      for (const double t : at) {
        wander += 0.02 * normal(random);
        signal.push_back(std::cos(2.0 * units::kPi * t * per_minute / 60.0) + wander +
                         0.1 * normal(random));
      }
      const Beat beat = find_beat(signal, at);
      EXPECT_GT(beat.f_ratio, 20.0) << per_minute;
      const double times_slower = per_minute / (60.0 * beat.rate_per_s);  // its overtones fit, too
      EXPECT_NEAR(times_slower, std::round(times_slower), 0.1) << per_minute;
    }
}

TEST(HeartSignal, WhatWandersDoesNotBeat) {
  const std::vector<double> at = times(133);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> signal{0.0};
    while (signal.size() < at.size()) signal.push_back(signal.back() + 0.1 * normal(random));
    EXPECT_LT(find_beat(signal, at).f_ratio, 20.0) << trial;
  }
}

/// A ball that goes up and down with the heart while the C-arm turns.
class BeatingBall : public FrameReader {
 public:
  BeatingBall(std::vector<angiogram::ConeBeamFrame> frames, double way_mm)
      : frames_(std::move(frames)), way_mm_(way_mm) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::vector<float> pixels;
    for (int f = first; f < first + count; ++f) {
      const double phase = f * kFrameTime / kBeat;
      const Vec3 up{0.0, 0.0, 0.5 * way_mm_ * beating(phase)};
      const PicturesOfBalls one(
          {frames_[std::size_t(f)]},
          {{Vec3{4.0, -3.0, 1.0} + up, 1.5, 0.1}, {Vec3{-5.0, 4.0, -2.0} + up, 1.2, 0.1}});
      const std::vector<float> frame = one.read(0, 1);
      pixels.insert(pixels.end(), frame.begin(), frame.end());
    }
    return pixels;
  }
  static constexpr double kBeat = 0.8;

 private:
  std::vector<angiogram::ConeBeamFrame> frames_;
  double way_mm_;
};

struct BeatingRun {
  std::vector<angiogram::ConeBeamFrame> frames = turn(133, -100.0, 100.0, 64, 48);
  BeatingBall pictures;
  RotationalRun run;
  explicit BeatingRun(double way_mm) : pictures(frames, way_mm) {
    run.frames = frames;
    run.pictures = &pictures;
    run.times_s = times(133);
    for (int n = 0; n < 6; ++n) run.r_waves_s.push_back(n * BeatingBall::kBeat);
  }
};

TEST(Gating, ByRWavesTakesThePhaseOfABeatingRun) {
  const BeatingRun beating_run(4.0);
  const Gate gate = gate_run(beating_run.run, 10000.0, {}, {});
  EXPECT_TRUE(gate.quality.is_gated);
  EXPECT_TRUE(gate.quality.by_r_waves);
  EXPECT_NEAR(gate.quality.heart_rate_per_min, 75.0, 0.1);
  EXPECT_NEAR(gate.quality.signal_rms_mm, 2.0 * std::sqrt(0.58), 0.25);
  EXPECT_GE(gate.frames.size(), 24u);
  for (const int frame : gate.frames) {
    const double beats = frame * kFrameTime / BeatingBall::kBeat;
    EXPECT_NEAR(beats - std::floor(beats), 0.75, 0.1001);
  }
}

TEST(Gating, OfStillVesselsTakesAllFrames) {
  const BeatingRun still(0.0);
  const Gate gate = gate_run(still.run, 10000.0, {}, {});
  EXPECT_FALSE(gate.quality.is_gated);
  EXPECT_EQ(gate.frames.size(), 133u);
}

/// A rod of balls along the axis, which looks the same wherever it is along it, and a wide bone
/// with an end that goes round.
TEST(Gating, OfAStillVesselBesideABoneTakesAllFrames) {
  BeatingRun still(0.0);
  std::vector<Ball> balls;
  for (int n = -12; n <= 12; ++n) balls.push_back({{0.0, 0.0, 1.0 * n}, 1.5, 0.03});
  for (int n = 0; n < 8; ++n) balls.push_back({{8.0, 6.0, -12.0 + 1.5 * n}, 6.0, 0.03});
  const PicturesOfBalls pictures(still.frames, balls);
  still.run.pictures = &pictures;
  still.run.r_waves_s.clear();
  const Gate gate = gate_run(still.run, 10000.0, {}, {});
  EXPECT_FALSE(gate.quality.is_gated) << gate.quality.signal_rms_mm;
  EXPECT_EQ(gate.warning, "");
}

TEST(Gating, WithoutRWavesFindsTheBeatInTheFrames) {
  BeatingRun beating_run(4.0);
  beating_run.run.r_waves_s.clear();
  const Gate gate = gate_run(beating_run.run, 10000.0, {}, {});
  EXPECT_TRUE(gate.quality.is_gated);
  EXPECT_FALSE(gate.quality.by_r_waves);
  EXPECT_NEAR(gate.quality.heart_rate_per_min, 75.0, 2.0);
  // The frames see the vessels within a small part of their way.
  double low = 1e9, high = -1e9;
  for (const int frame : gate.frames) {
    const double place = 2.0 * beating(frame * kFrameTime / BeatingBall::kBeat);
    low = std::min(low, place);
    high = std::max(high, place);
  }
  EXPECT_LT(high - low, 1.2);
}

TEST(Gating, OfTooFewBeatsWarns) {
  BeatingRun beating_run(4.0);
  beating_run.run.frames = turn(60, -100.0, 100.0, 64, 48);
  const BeatingBall pictures(beating_run.run.frames, 4.0);
  beating_run.run.pictures = &pictures;
  beating_run.run.times_s = times(60);
  const Gate gate = gate_run(beating_run.run, 10000.0, {}, {});
  EXPECT_FALSE(gate.quality.is_gated);
  EXPECT_THAT(gate.warning, HasSubstr("2.4 beats"));
}

TEST(Gating, ThatIsAskedForNeedsTimes) {
  BeatingRun beating_run(4.0);
  beating_run.run.times_s.clear();
  ReconstructionOptions options;
  EXPECT_EQ(gate_run(beating_run.run, 10000.0, options, {}).frames.size(), 133u);
  options.gating = Gating::on;
  EXPECT_THROW(gate_run(beating_run.run, 10000.0, options, {}), InputError);
}

TEST(Gating, ReadsTheFramesThatItTook) {
  const BeatingRun beating_run(4.0);
  const GatedRun gated(beating_run.run, {3, 4, 9});
  const std::vector<float> some = gated.run().pictures->read(1, 2);
  const std::vector<float> fourth = beating_run.pictures.read(4, 1),
                           ninth = beating_run.pictures.read(9, 1);
  ASSERT_EQ(some.size(), fourth.size() + ninth.size());
  EXPECT_TRUE(std::equal(fourth.begin(), fourth.end(), some.begin()));
  EXPECT_TRUE(std::equal(ninth.begin(), ninth.end(), some.begin() + std::ptrdiff_t(fourth.size())));
  EXPECT_EQ(gated.run().frames.size(), 3u);
}

/// Beads on a helix that beat, and go up and back with a breath of 2.6 s.
class BreathingBeads : public FrameReader {
 public:
  explicit BreathingBeads(std::vector<angiogram::ConeBeamFrame> frames)
      : frames_(std::move(frames)) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::vector<float> pixels;
    for (int f = first; f < first + count; ++f) {
      const double heart = beating(f * kFrameTime / BeatingBall::kBeat),
                   breath = std::sin(2.0 * units::kPi * f * kFrameTime / 2.6);
      std::vector<Ball> balls;
      for (int n = 0; n < 9; ++n)
        balls.push_back({Vec3{9.0 * std::cos(0.9 * n), 9.0 * std::sin(0.9 * n), 2.0 * (n - 4)} +
                             heart * Vec3{0.0, 0.0, 1.5} + breath * Vec3{0.0, -0.9, -3.0},
                         1.2, 0.1});
      const std::vector<float> one = PicturesOfBalls({frames_[std::size_t(f)]}, balls).read(0, 1);
      pixels.insert(pixels.end(), one.begin(), one.end());
    }
    return pixels;
  }

 private:
  std::vector<angiogram::ConeBeamFrame> frames_;
};

/// The beads come out of the blur: what is seen of them in a voxel rises towards their own.
TEST(Gating, BreathIsFittedAsAMotionOfTheCArm) {
  RotationalRun run;
  run.frames = turn(133, -100.0, 100.0, 64, 64);
  const BreathingBeads pictures(run.frames);
  run.pictures = &pictures;
  run.times_s = times(133);
  for (int n = 0; n < 6; ++n) run.r_waves_s.push_back(n * BeatingBall::kBeat);
  const auto amount_at_peak = [&](bool calibrate) {
    ReconstructionOptions options;
    options.calibrate = calibrate;
    const Reconstruction result = reconstruct_volume(run, options);
    EXPECT_TRUE(result.quality.gating.is_gated);
    if (calibrate) {
      EXPECT_GT(result.quality.calibration_passes, 0);
      EXPECT_LT(result.quality.residual_pixels, 0.5 * result.quality.given_residual_pixels);
    }
    std::vector<float> values = result.volume.values;
    const auto top = values.end() - std::ptrdiff_t(values.size() / 2000);
    std::nth_element(values.begin(), top, values.end());
    return double(*top);
  };
  const double as_told = amount_at_peak(false), fitted = amount_at_peak(true);
  EXPECT_GT(fitted, 1.3 * as_told);
}

}  // namespace
}  // namespace angio::reconstruction::detail

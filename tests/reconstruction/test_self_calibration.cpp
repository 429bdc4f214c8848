#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "reconstruction/detail/self_calibration.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction::detail {
namespace {

using tests::Ball;
using tests::PicturesOfBalls;
using tests::turn;

/// Beads on a helix, which a frame sees from no side in a line.
std::vector<Ball> beads(double radius = 1.4) {
  std::vector<Ball> balls;
  for (int n = 0; n < 9; ++n) {
    const double angle = 0.9 * n;
    balls.push_back({{9.0 * std::cos(angle), 9.0 * std::sin(angle), 2.2 * (n - 4)}, radius, 0.08});
  }
  return balls;
}

std::vector<BrightPoint> points_of(const std::vector<Ball>& balls) {
  constexpr double kStep = 0.35;
  std::vector<BrightPoint> points;
  for (const Ball& ball : balls)
    for (double x = -ball.radius; x <= ball.radius; x += kStep)
      for (double y = -ball.radius; y <= ball.radius; y += kStep)
        for (double z = -ball.radius; z <= ball.radius; z += kStep)
          if (norm(Vec3{x, y, z}) < ball.radius)
            points.push_back(
                {ball.middle + Vec3{x, y, z}, ball.attenuation * kStep * kStep * kStep});
  return points;
}

std::vector<float> line_integrals(const angiogram::ConeBeamFrame& frame) {
  std::vector<float> pixels = PicturesOfBalls({frame}, beads(), 1.0).read(0, 1);
  for (float& pixel : pixels) pixel = -std::log(pixel);
  return pixels;
}

/// The greatest distance in the picture between where two frames see the beads [pixels].
double apart(const angiogram::ConeBeamFrame& a, const angiogram::ConeBeamFrame& b) {
  double most = 0.0;
  for (const Ball& ball : beads()) {
    const auto x = angiogram::ConeBeamView(a).see(ball.middle),
               y = angiogram::ConeBeamView(b).see(ball.middle);
    most = std::max(most, std::hypot(x.column - y.column, x.row - y.row));
  }
  return most;
}

TEST(FitFrame, FindsHowTheCArmStands) {
  const auto frames = turn(7, -90.0, 90.0);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const double sign = f % 2 == 0 ? 1.0 : -1.0;
    const auto real = moved(frames[f], {sign * Vec3{0.004, -0.003, 0.005}, {0.4, 0.3, -0.5}});
    const FrameFit fit = fit_frame(frames[f], {}, line_integrals(real), points_of(beads()), 0.8);
    ASSERT_TRUE(fit.is_fitted);
    EXPECT_GT(apart(frames[f], real), 0.9);
    EXPECT_LT(apart(moved(frames[f], fit.motion), real), 0.05) << "frame " << f;
  }
}

TEST(FitFrame, LeavesAFrameThatStandsRight) {
  const auto frame = turn(3, 0.0, 90.0)[1];
  const FrameFit fit = fit_frame(frame, {}, line_integrals(frame), points_of(beads()), 0.8);
  EXPECT_LT(fit.moved_pixels, 0.03);
}

TEST(FitFrame, IsNotMisledByABodyAndLessContrastMedium) {
  const auto frames = turn(3, 0.0, 90.0);
  const auto real = moved(frames[1], {{0.0, 0.0, 0.004}, {0.5, 0.0, 0.4}});
  std::vector<float> pixels = line_integrals(real);
  for (int row = 0; row < real.rows; ++row)
    for (int c = 0; c < real.columns; ++c) {
      float& pixel = pixels[std::size_t(row * real.columns + c)];
      pixel = 0.7F * pixel + 2.0F + 0.004F * float(c) - 0.002F * float(row);
    }
  const FrameFit fit = fit_frame(frames[1], {}, pixels, points_of(beads()), 0.8);
  EXPECT_LT(apart(moved(frames[1], fit.motion), real), 0.08);
}

TEST(TakeOutCommon, LeavesMotionsWhoseMeanIsNone) {
  std::vector<Motion> motions = {{{0.1, 0.0, 0.2}, {1, 2, 3}}, {{0.3, 0.0, 0.0}, {3, 2, 1}}};
  take_out_common(motions);
  EXPECT_LT(norm(motions[0].turn + motions[1].turn), 1e-15);
  EXPECT_LT(norm(motions[0].shift + motions[1].shift), 1e-15);
}

/// Each frame off by up to a pixel and a half: the run is nearly as sharp as one that stands right.
TEST(SelfCalibration, BringsBackAWobblingRun) {
  const auto told = turn(90, -100.0, 100.0);
  std::vector<angiogram::ConeBeamFrame> real;
  for (std::size_t f = 0; f < told.size(); ++f) {
    const auto wave = [&](double pace, double phase) { return std::sin(pace * double(f) + phase); };
    real.push_back(moved(told[f], {0.004 * Vec3{wave(1.1, 0), wave(2.3, 1), wave(1.7, 2)},
                                   0.5 * Vec3{wave(2.9, 0), wave(1.3, 1), wave(0.9, 2)}}));
  }
  const auto middle_of = [&](const std::vector<angiogram::ConeBeamFrame>& frames, bool calibrate) {
    const std::vector<Ball> balls = beads(0.8);
    const PicturesOfBalls pictures(real, balls);
    RotationalRun run;
    run.frames = frames;
    run.pictures = &pictures;
    ReconstructionOptions options;
    options.calibrate = calibrate;
    const Reconstruction result = reconstruct_volume(run, options);
    double sum = 0.0;
    for (const Ball& ball : balls) sum += interpolate(result.volume, ball.middle) / 0.08 / 9.0;
    if (calibrate) {
      EXPECT_GT(result.quality.given_residual_pixels, 0.5);
      EXPECT_LT(result.quality.residual_pixels, 0.15);
    }
    return sum;
  };
  const double right = middle_of(real, false);
  EXPECT_LT(middle_of(told, false), 0.9 * right);
  EXPECT_GT(middle_of(told, true), 0.97 * right);
}

/// Frames told to be 15.4 degrees apart, which really lie up to 18.8 apart.
TEST(SelfCalibration, DoesNotTurnARunIntoOneOfFewViews) {
  const auto told = turn(14, -100.0, 100.0);
  std::vector<angiogram::ConeBeamFrame> real;
  for (std::size_t f = 0; f < told.size(); ++f)
    real.push_back(moved(told[f], {{0.0, 0.0, f % 2 == 0 ? 0.03 : -0.03}, {}}));
  const PicturesOfBalls pictures(real, beads());
  RotationalRun run;
  run.frames = told;
  run.pictures = &pictures;
  const Reconstruction result = reconstruct_volume(run, {});
  EXPECT_GT(result.quality.calibration_passes, 0);
  EXPECT_GT(result.quality.largest_step_degrees, kFewViewsDegrees);
  EXPECT_EQ(result.quality.method, Method::fdk);
}

}  // namespace
}  // namespace angio::reconstruction::detail

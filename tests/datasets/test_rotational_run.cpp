#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "datasets/rotational_run.hpp"

namespace angio::datasets {
namespace {

PhantomOptions short_tube() {
  PhantomOptions options;
  options.name = "straight";
  options.length_mm = 12.0;
  return options;
}

RotationalRunOptions bare() {
  RotationalRunOptions run;
  run.frames = 9;
  run.noise = 0.0;
  run.body = false;
  return run;
}

double pixel(const RotationalRunOfPhantom& run, int frame, int row, int column) {
  return run.pictures[(std::size_t(frame) * std::size_t(run.mount.rows) + std::size_t(row)) *
                          std::size_t(run.mount.columns) +
                      std::size_t(column)];
}

TEST(RotationalRunOfPhantom, WeakensTheBeamAsBeerAndLambertSay) {
  const auto run = make_rotational_run(short_tube(), bare());
  const double radius = run.phantom.truth.mld_mm / 2.0;
  // Rays through the axis, across the vessel: 2 r. The four of a pixel lie beside it.
  for (int f = 0; f < 9; ++f) {
    const double middle = pixel(run, f, run.mount.rows / 2, run.mount.columns / 2);
    EXPECT_NEAR(std::log(60000.0 / middle), 0.1 * 2.0 * radius, 0.1 * 0.05) << f;
    EXPECT_EQ(pixel(run, f, run.mount.rows / 2, 0), 60000.0);
  }
}

TEST(RotationalRunOfPhantom, HoldsAllOfTheContrastMediumInEveryFrame) {
  const auto run = make_rotational_run(short_tube(), bare());
  const double radius = run.phantom.truth.mld_mm / 2.0, volume = M_PI * radius * radius * 12.0;
  for (int f = 0; f < 9; ++f) {
    double sum = 0.0;
    for (int row = 0; row < run.mount.rows; ++row)
      for (int c = 0; c < run.mount.columns; ++c) sum += std::log(60000.0 / pixel(run, f, row, c));
    EXPECT_NEAR(sum * 0.3 * 0.3 / 0.1, volume, 0.01 * volume) << f;
  }
}

TEST(RotationalRunOfPhantom, HasTheNoiseBehindTheBodyThatIsAskedFor) {
  RotationalRunOptions options = bare();
  options.frames = 60;
  options.body = options.mask_run = true;
  options.noise = 0.03;
  const auto run = make_rotational_run(short_tube(), options);
  double sum = 0.0, squares = 0.0;
  const std::size_t per_frame = std::size_t(run.mount.rows) * std::size_t(run.mount.columns);
  // The frame from the front, beside the bone behind.
  const std::size_t first = 30 * per_frame;
  int count = 0;
  for (std::size_t p = first + 1; p < first + per_frame; ++p, ++count) {
    const double a = run.masks[p - 1], b = run.masks[p];
    sum += 0.5 * (a + b);
    squares += 0.5 * (a - b) * (a - b);
  }
  const double noise = std::sqrt(squares / count) / (sum / count);
  EXPECT_GT(noise, 0.015);
  EXPECT_LT(noise, 0.04);
}

TEST(RotationalRunOfPhantom, GivesTheSamePixelsAgain) {
  RotationalRunOptions options = bare();
  options.noise = 0.02;
  options.wobble_mm = 0.5;
  EXPECT_EQ(make_rotational_run(short_tube(), options).pictures,
            make_rotational_run(short_tube(), options).pictures);
}

/// The contrast medium's amount does not depend on where the vessel has gone: only its volume does,
/// which the heart's motion changes by its divergence alone.
TEST(RotationalRunOfPhantom, MovesWithBreathAndFills) {
  RotationalRunOptions options = bare();
  options.breathing_mm = 6.0;
  options.frame_time_ms = 500.0;  // frame 4 is breathed in
  options.inflow_s = 2.0;
  const auto run = make_rotational_run(short_tube(), options);
  const auto sums = [&](int frame) {
    double sum = 0.0, height = 0.0;
    for (int row = 0; row < run.mount.rows; ++row)
      for (int c = 0; c < run.mount.columns; ++c) {
        const double p = std::log(60000.0 / pixel(run, frame, row, c));
        sum += p;
        height -= p * (row - run.mount.central_row) * 0.3;
      }
    return std::pair{sum, height / sum};
  };
  EXPECT_NEAR(sums(2).first / sums(8).first, 0.5, 0.02);
  EXPECT_NEAR(sums(8).second, 0.0, 0.1);  // breathed out again
  EXPECT_NEAR(sums(4).second, run.motion.breathing_shifts_mm[4].z, 0.1);
  EXPECT_LT(run.motion.breathing_shifts_mm[4].z, -5.0);
}

TEST(RotationalRunOptions, OutOfRangeAreRefused) {
  RotationalRunOptions options;
  options.frames = 2;
  EXPECT_THROW(options.validate(), OptionError);
  options = {};
  options.source_to_detector_mm = 700.0;
  EXPECT_THROW(options.validate(), OptionError);
  options = {};
  options.wobble_mm = -1.0;
  EXPECT_THROW(options.validate(), OptionError);
  options = {};
  options.heart_rate_per_min = 10.0;
  EXPECT_THROW(options.validate(), OptionError);
}

TEST(RotationalRunOfPhantom, OfASheetIsRefused) {
  PhantomOptions cloth;
  cloth.name = "cloth";
  EXPECT_THROW(make_rotational_run(cloth, bare()), InputError);
}

}  // namespace
}  // namespace angio::datasets

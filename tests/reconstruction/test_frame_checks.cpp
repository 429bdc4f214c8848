#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/error.hpp"
#include "reconstruction/detail/frame_checks.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction::detail {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using tests::turn;

/// Pixels of a function of frame, column and row, with noise of their own.
class MadePictures : public FrameReader {
 public:
  using Pixel = std::function<double(int frame, int column, int row, double normal)>;
  MadePictures(int columns, int rows, Pixel pixel)
      : columns_(columns), rows_(rows), pixel_(std::move(pixel)) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::vector<float> pixels;
    for (int f = first; f < first + count; ++f) {
      std::mt19937 random{unsigned(f)};
      std::normal_distribution<double> normal;
      for (int r = 0; r < rows_; ++r)
        for (int c = 0; c < columns_; ++c) pixels.push_back(float(pixel_(f, c, r, normal(random))));
    }
    return pixels;
  }

 private:
  int columns_, rows_;
  Pixel pixel_;
};

constexpr int kColumns = 128, kRows = 96;

RotationalRun run_of(const FrameReader& pictures, PixelRelation relation, int frames = 30) {
  RotationalRun run;
  run.frames = turn(frames, -100.0, 100.0, kColumns, kRows);
  run.pictures = &pictures;
  run.relation = relation;
  return run;
}

/// Photons behind a body that lets through less from left to right.
double photons(int column, double normal) {
  const double mean = 20000.0 * std::exp(-1.5 * column / kColumns);
  return mean + std::sqrt(mean) * normal;
}

TEST(FrameChecks, NoiseTellsLinearPixelsFromLogarithmicOnes) {
  const MadePictures linear(kColumns, kRows,
                            [](int, int c, int, double n) { return photons(c, n); });
  const MadePictures logarithmic(
      kColumns, kRows, [](int, int c, int, double n) { return 4000.0 * std::log(photons(c, n)); });
  EXPECT_THAT(doubt_of_relation(run_of(linear, PixelRelation::linear)), IsEmpty());
  EXPECT_THAT(doubt_of_relation(run_of(logarithmic, PixelRelation::logarithmic)), IsEmpty());
  EXPECT_THAT(doubt_of_relation(run_of(linear, PixelRelation::logarithmic)),
              HasSubstr("as in linear ones"));
  EXPECT_THAT(doubt_of_relation(run_of(logarithmic, PixelRelation::linear)),
              HasSubstr("as in logarithmic"));
}

TEST(FrameChecks, PixelsWithoutNoiseTellNothing) {
  const MadePictures clean(kColumns, kRows,
                           [](int, int c, int, double) { return photons(c, 0.0); });
  EXPECT_THAT(doubt_of_relation(run_of(clean, PixelRelation::logarithmic)), IsEmpty());
}

TEST(FrameChecks, ContrastThatComesLateIsSeenInTheSumsOfFrames) {
  const MadePictures mask(kColumns, kRows, [](int, int c, int, double n) { return photons(c, n); });
  const auto doubt = [&](double seconds_full) {
    const MadePictures filled(kColumns, kRows, [=](int f, int c, int r, double n) {
      const double full = std::min(1.0, seconds_full > 0.0 ? f / 30.0 / seconds_full : 1.0);
      return photons(c, n) * std::exp(-0.3 * full * (std::abs(r - 48) < 5 ? 1.0 : 0.0));
    });
    RotationalRun run = run_of(filled, PixelRelation::linear);
    run.masks = &mask;
    return doubt_of_filling(run);
  };
  EXPECT_THAT(doubt(0.0), IsEmpty());
  EXPECT_THAT(doubt(0.5), HasSubstr("contrast medium comes in"));
}

/// Frames of one run, and from some frame on those of another.
class OneThenTheOther : public FrameReader {
 public:
  OneThenTheOther(const FrameReader& one, const FrameReader& other, int from)
      : one_(one), other_(other), from_(from) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::vector<float> pixels;
    for (int f = first; f < first + count; ++f) {
      const std::vector<float> frame = (f < from_ ? one_ : other_).read(f, 1);
      pixels.insert(pixels.end(), frame.begin(), frame.end());
    }
    return pixels;
  }

 private:
  const FrameReader &one_, &other_;
  int from_;
};

TEST(FrameChecks, ContrastThatComesLateIsSeenWhereTheVolumesVesselsAre) {
  const std::vector<tests::Ball> body = {{{0.0, 0.0, 0.0}, 14.0, 0.02}};
  std::vector<tests::Ball> filled = body;
  for (int n = 0; n < 8; ++n)
    filled.push_back({{3.0 * std::cos(n), 8.0 * std::sin(n), 1.5 * n - 5.0}, 1.5, 0.1});
  const auto frames = turn(60, -100.0, 100.0);
  const tests::PicturesOfBalls empty(frames, body), full(frames, filled);
  const auto warnings = [&](int filled_from) {
    const OneThenTheOther pictures(empty, full, filled_from);
    RotationalRun run;
    run.frames = frames;
    run.pictures = &pictures;
    return reconstruct_volume(run, {}).warnings;
  };
  EXPECT_THAT(warnings(0), testing::Not(testing::Contains(HasSubstr("contrast medium"))));
  EXPECT_THAT(warnings(20), testing::Contains(HasSubstr("contrast medium comes in")));
}

TEST(FrameChecks, LogarithmsOfNoStatedUnitAreToldOf) {
  const auto doubt = [](double unit) {
    const MadePictures pictures(
        kColumns, kRows, [=](int, int c, int, double) { return unit * std::log(photons(c, 0.0)); });
    return doubt_of_scale(run_of(pictures, PixelRelation::logarithmic),
                          unit * std::log(photons(0, 0.0)));
  };
  EXPECT_THAT(doubt(1.0), IsEmpty());
  EXPECT_THAT(doubt(4000.0), HasSubstr("not to scale"));
}

TEST(FrameChecks, AFewFramesMakeNoVolume) {
  const MadePictures pictures(kColumns, kRows,
                              [](int, int c, int, double n) { return photons(c, n); });
  EXPECT_THROW(reconstruct_volume(run_of(pictures, PixelRelation::linear, 5), {}), InputError);
}

}  // namespace
}  // namespace angio::reconstruction::detail

#include <gtest/gtest.h>

#include "reconstruction/shown_frames.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction {
namespace {

const std::vector<tests::Ball> kShownBall = {{{6.0, -4.0, 3.0}, 5.0, 0.02}};

ShownFrames show(const std::vector<angiogram::ConeBeamFrame>& frames) {
  const tests::PicturesOfBalls pictures(frames, kShownBall);
  RotationalRun run;
  run.frames = frames;
  run.pictures = &pictures;
  Reconstruction result;
  result.frames = frames;
  for (int f = 0; f < int(frames.size()); ++f) result.used.push_back(f);
  result.quality.unattenuated = 10000.0;
  return show_frames(run, result);
}

TEST(ShownFrames, AreEvenlySpreadFromTheFirstToTheLast) {
  EXPECT_EQ(show(tests::turn(71, 0.0, 200.0)).indices,
            (std::vector<int>{0, 10, 20, 30, 40, 50, 60, 70}));
  EXPECT_EQ(show(tests::turn(3, 0.0, 200.0)).indices, (std::vector<int>{0, 1, 2}));
}

/// Pixels may be larger, but they lie where the frame says: a ray through a pixel's middle meets as
/// much of the ball as the pixel has.
TEST(ShownFrames, HoldTheLineIntegralsOfTheirRays) {
  const ShownFrames shown = show(tests::turn(20, 0.0, 200.0, 900, 64));
  const auto& size = shown.pictures.geometry.size;
  EXPECT_EQ(size[0], 300);
  EXPECT_EQ(size[1], 21);
  for (std::size_t n = 0; n < shown.frames.size(); ++n) {
    const angiogram::ConeBeamFrame& frame = shown.frames[n];
    EXPECT_EQ(frame.columns, size[0]);
    EXPECT_EQ(frame.rows, size[1]);
    for (int row = 0; row < size[1]; ++row)
      for (int column = 0; column < size[0]; ++column)
        EXPECT_NEAR(shown.pictures.at(column, row, int(n)),
                    tests::line_integral(kShownBall, frame.source, frame.place(column, row)), 0.04);
    // In the ball's middle, where it hardly bends, much nearer.
    const angiogram::SeenPoint seen = angiogram::ConeBeamView(frame).see(kShownBall[0].middle);
    const int column = int(std::lround(seen.column)), row = int(std::lround(seen.row));
    EXPECT_NEAR(shown.pictures.at(column, row, int(n)),
                tests::line_integral(kShownBall, frame.source, frame.place(column, row)), 0.004);
  }
}

}  // namespace
}  // namespace angio::reconstruction

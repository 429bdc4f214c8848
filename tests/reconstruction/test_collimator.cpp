#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "reconstruction/detail/collimator.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction {
namespace {

using detail::open_field;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using tests::Ball;
using tests::PicturesOfBalls;
using tests::turn;

constexpr int kColumns = 200, kRows = 160;

/// Line integrals of 0.3, and 1.5 more where something dark is.
template <typename IsDark>
std::vector<float> picture_with(const IsDark& is_dark) {
  std::vector<float> picture;
  for (int r = 0; r < kRows; ++r)
    for (int c = 0; c < kColumns; ++c) picture.push_back(is_dark(c, r) ? 1.8F : 0.3F);
  return picture;
}

OpenField open_of(const std::vector<float>& picture) {
  return open_field(picture, kColumns, kRows);
}

/// Three in a hundred are left out at each side for a leaf's blur.
constexpr int kBlurColumns = 6, kBlurRows = 4;

TEST(OpenField, IsAllOfAPictureThatNothingCovers) {
  const OpenField open = open_of(picture_with([](int, int) { return false; }));
  EXPECT_EQ(open.first_column, kBlurColumns);
  EXPECT_EQ(open.last_column, kColumns - 1 - kBlurColumns);
  EXPECT_EQ(open.first_row, kBlurRows);
  EXPECT_EQ(open.last_row, kRows - 1 - kBlurRows);
}

TEST(OpenField, EndsAtLeavesOnAllSidesThatMayBeTilted) {
  // 30 columns left, a leaf tilted by 3 degrees; 25 right; 20 rows above; 18 below, corners round.
  const OpenField open = open_of(picture_with([](int c, int r) {
    const bool in_corner = std::hypot(std::max(0, 45 - c), std::max(0, 35 - r)) > 15.0;
    return c < 30 + 0.05 * (r - kRows / 2) || c >= kColumns - 25 || r < 20 || r >= kRows - 18 ||
           (in_corner && c < 45 && r < 35);
  }));
  EXPECT_NEAR(open.first_column, 34 + kBlurColumns, 1);  // where the leaf reaches farthest
  EXPECT_EQ(open.last_column, kColumns - 1 - 25 - kBlurColumns);
  EXPECT_EQ(open.first_row, 20 + kBlurRows);
  EXPECT_EQ(open.last_row, kRows - 1 - 18 - kBlurRows);
}

TEST(OpenField, EndsAtALeafThatSomethingDarkJoins) {
  // 20 rows above; a wire, a spine of 30 columns, or a leaf of a quarter of the picture beside it.
  for (const auto& [first, last] : {std::pair{90, 95}, std::pair{85, 115}, std::pair{0, 50}}) {
    const OpenField open =
        open_of(picture_with([&](int c, int r) { return r < 20 || (c >= first && c < last); }));
    EXPECT_EQ(open.first_row, 20 + kBlurRows);
    EXPECT_EQ(open.first_column, (first == 0 ? 50 : 0) + kBlurColumns);
  }
}

TEST(OpenField, DoesNotEndAtABandOffTheBorder) {
  const OpenField open = open_of(picture_with([](int, int r) { return r >= 25 && r < 45; }));
  EXPECT_EQ(open.first_row, kBlurRows);
}

TEST(OpenField, DoesNotEndWhereRoundBoneReachesIn) {
  // A skull of 120 pixels' radius, 45 columns of which are in the picture, from each side in turn.
  for (const bool from_right : {false, true}) {
    const OpenField open = open_of(picture_with([&](int c, int r) {
      const double from_side = from_right ? kColumns - 1 - c : c;
      return std::hypot(from_side + 75.0, r - kRows / 2) < 120.0;
    }));
    EXPECT_EQ(open.first_column, kBlurColumns);
    EXPECT_EQ(open.last_column, kColumns - 1 - kBlurColumns);
  }
  // From above, its base 40 rows deep.
  const OpenField open = open_of(
      picture_with([](int c, int r) { return std::hypot(c - kColumns / 2, r + 80.0) < 120.0; }));
  EXPECT_EQ(open.first_row, kBlurRows);
}

constexpr int kRunColumns = 96, kRunRows = 64;

/// A run's pictures behind leaves that stand still and let part of the beam through.
class BehindLeaves : public FrameReader {
 public:
  using Share = std::function<double(int column, int row)>;
  BehindLeaves(const FrameReader& open, Share share) : open_(open), share_(std::move(share)) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::vector<float> pixels = open_.read(first, count);
    for (std::size_t i = 0; i < pixels.size(); ++i)
      pixels[i] *= float(share_(int(i % kRunColumns), int(i / kRunColumns % kRunRows)));
    return pixels;
  }

 private:
  const FrameReader& open_;
  Share share_;
};

/// A body of 44 mm, a ball of contrast medium and bone that turn with it, shoulders below.
struct TurningBody {
  TurningBody()
      : pictures(turn(30, -110.0, 110.0, kRunColumns, kRunRows),
                 {Ball{{0.0, 0.0, 3.0}, 22.0, 0.03}, Ball{{3.0, -2.0, 0.0}, 1.5, 0.4},
                  Ball{{-8.0, 5.0, 2.0}, 3.0, 0.1}, Ball{{0.0, 0.0, -26.0}, 18.0, 0.08}}) {
    run.frames = turn(30, -110.0, 110.0, kRunColumns, kRunRows);
    run.pictures = &pictures;
  }
  PicturesOfBalls pictures;
  RotationalRun run;
};

TEST(OpenFieldOfARun, IsNotToldWhereNothingCoversIt) {
  const TurningBody body;
  EXPECT_FALSE(open_field(body.run));
}

TEST(OpenFieldOfARun, EndsAtLeavesThatStandStill) {
  // One that lets nothing through, one that lets through six tenths, and leans by two columns.
  TurningBody body;
  const BehindLeaves pictures(body.pictures, [](int c, int r) {
    return c < 14 ? 0.001 : c >= kRunColumns - 20 + r / 32 ? 0.6 : 1.0;
  });
  body.run.pictures = &pictures;
  const auto open = open_field(body.run);
  ASSERT_TRUE(open);
  EXPECT_GE(open->first_column, 14);
  EXPECT_LE(open->first_column, 19);
  EXPECT_LE(open->last_column, kRunColumns - 1 - 20);
  EXPECT_GE(open->last_column, kRunColumns - 1 - 25);
  EXPECT_EQ(open->first_row, 0);
  EXPECT_EQ(open->last_row, kRunRows - 1);
}

TEST(OpenFieldOfARun, IsTheVolumesField) {
  TurningBody body;
  const BehindLeaves pictures(
      body.pictures, [](int c, int) { return c < 20 || c >= kRunColumns - 20 ? 0.5 : 1.0; });
  ReconstructionOptions options;
  options.calibrate = false;
  const Reconstruction as_it_is = reconstruct_volume(body.run, options);
  body.run.pictures = &pictures;
  const Reconstruction found = reconstruct_volume(body.run, options);
  EXPECT_THAT(as_it_is.warnings, Not(Contains(HasSubstr("collimator"))));
  EXPECT_THAT(found.warnings, Contains(HasSubstr("collimator")));
  EXPECT_LT(found.quality.field_radius_mm, 0.65 * as_it_is.quality.field_radius_mm);
  // The ball of contrast medium is as dense behind the leaves' opening as without them.
  const auto at_ball = [](const Volume<float>& volume) {
    const Vec3 index = volume.geometry.index_from_lps({3.0, -2.0, 0.0});
    return double(
        volume.at(int(std::lround(index.x)), int(std::lround(index.y)), int(std::lround(index.z))));
  };
  EXPECT_NEAR(at_ball(found.volume), at_ball(as_it_is.volume), 0.1 * at_ball(as_it_is.volume));
}

}  // namespace
}  // namespace angio::reconstruction

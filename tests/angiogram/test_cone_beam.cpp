#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "angiogram/cone_beam.hpp"
#include "core/error.hpp"
#include "testing/shapes.hpp"

namespace angio::angiogram {
namespace {

CArmMount small_mount() {
  CArmMount mount;
  mount.columns = 61;
  mount.rows = 41;
  mount.central_column = 30.0;
  mount.central_row = 20.0;
  return mount;
}

constexpr CArmAngles kOblique{37.0, 18.0};

TEST(ConeBeamFrame, SeesTheIsocentreWhereItsMountSays) {
  const SeenPoint seen = ConeBeamView(c_arm_frame(kOblique, small_mount())).see({});
  EXPECT_NEAR(seen.column, 30.0, 1e-9);
  EXPECT_NEAR(seen.row, 20.0, 1e-9);
  EXPECT_NEAR(seen.depth, 800.0 / 1200.0, 1e-12);
}

TEST(ConeBeamFrame, OfTheFrontHasThePatientsLeftAtTheRightAndTheHeadAbove) {
  const ConeBeamView view(c_arm_frame({0.0, 0.0}, small_mount()));
  EXPECT_GT(view.see({5.0, 0.0, 0.0}).column, 30.0);
  EXPECT_LT(view.see({0.0, 0.0, 5.0}).row, 20.0);
}

TEST(ConeBeamFrame, MagnifiesByTheRatioOfTheDistances) {
  const ConeBeamView view(c_arm_frame({0.0, 0.0}, small_mount()));
  EXPECT_NEAR(view.see({4.0, 0.0, 0.0}).column - 30.0, 4.0 * 1.5 / 0.4, 1e-9);
}

TEST(ConeBeamFrame, SeesEveryPlaceOfItsDetectorAtItsPixel) {
  const ConeBeamFrame frame = c_arm_frame(kOblique, small_mount());
  const SeenPoint seen = ConeBeamView(frame).see(frame.place(7.0, 33.0));
  EXPECT_NEAR(seen.column, 7.0, 1e-9);
  EXPECT_NEAR(seen.row, 33.0, 1e-9);
  EXPECT_NEAR(seen.depth, 1.0, 1e-12);
}

TEST(ConeBeamFrame, ComesBackFromItsMatrixWhateverItsScaleAndSign) {
  const ConeBeamFrame frame = c_arm_frame(kOblique, small_mount());
  auto matrix = ConeBeamView(frame).matrix();
  for (auto& row : matrix)
    for (double& value : row) value *= -3.5;
  const ConeBeamFrame back = frame_from_matrix(matrix, {}, 61, 41);
  EXPECT_LT(distance(back.source, frame.source), 1e-6);
  for (const Vec3 point : {Vec3{3, 4, 5}, Vec3{-10, 2, 0}}) {
    const SeenPoint a = ConeBeamView(frame).see(point), b = ConeBeamView(back).see(point);
    EXPECT_NEAR(a.column, b.column, 1e-6);
    EXPECT_NEAR(a.row, b.row, 1e-6);
    EXPECT_GT(b.depth, 0.0);
  }
}

TEST(ConeBeamFrame, WithoutDepthIsRefused) {
  ConeBeamFrame flat;
  flat.column_step = {1, 0, 0};
  flat.row_step = {0, 1, 0};
  flat.first_pixel = {5, 5, 0};
  EXPECT_THROW(ConeBeamView{flat}, InputError);
  EXPECT_THROW(frame_from_matrix({}, {}, 1, 1), InputError);
}

/// The ray's way through a ball: 2 sqrt(r^2 - d^2), d its distance from the ball's middle.
double chord_of_ball(const ConeBeamFrame& frame, double column, double row, const Vec3& middle,
                     double radius) {
  const Vec3 ray = normalized(frame.place(column, row) - frame.source);
  const double d = norm(cross(middle - frame.source, ray));
  return d < radius ? 2.0 * std::sqrt(radius * radius - d * d) : 0.0;
}

TEST(ConeBeamChords, OfABallAreThoseOfItsFormula) {
  const Vec3 middle{2.0, -1.0, 1.5};
  const TriangleMesh ball = tests::make_sphere(middle, 4.0, 7);
  const ConeBeamFrame frame = c_arm_frame(kOblique, small_mount());
  const auto chords = chord_lengths(ball, frame);
  double greatest_error = 0.0;
  int hits = 0;
  for (int row = 0; row < frame.rows; ++row)
    for (int c = 0; c < frame.columns; ++c) {
      const double exact = chord_of_ball(frame, c, row, middle, 4.0);
      if (exact == 0.0 || exact > 3.0) {  // at the rim the ball's facets tell
        greatest_error = std::max(greatest_error,
                                  std::abs(chords[std::size_t(row * frame.columns + c)] - exact));
        hits += exact > 3.0;
      }
    }
  EXPECT_GT(hits, 200);
  EXPECT_LT(greatest_error, 0.01);
}

TEST(ConeBeamChords, AreTheSameInAMirroredPicture) {
  const TriangleMesh ball = tests::make_sphere({1.0, 2.0, 0.0}, 4.0, 4);
  const ConeBeamFrame frame = c_arm_frame(kOblique, small_mount());
  ConeBeamFrame mirrored = frame;
  mirrored.first_pixel = frame.place(frame.columns - 1, 0);
  mirrored.column_step = -frame.column_step;
  const auto a = chord_lengths(ball, frame), b = chord_lengths(ball, mirrored);
  for (int row = 0; row < frame.rows; ++row)
    for (int c = 0; c < frame.columns; ++c)
      ASSERT_NEAR(a[std::size_t(row * frame.columns + c)],
                  b[std::size_t((row + 1) * frame.columns - 1 - c)], 1e-6);
}

TEST(ConeBeamChords, BehindTheSourceAreRefused) {
  EXPECT_THROW(chord_lengths(tests::make_sphere({0, 900, 0}, 4.0, 3),
                             c_arm_frame({0.0, 0.0}, small_mount())),
               InputError);
}

}  // namespace
}  // namespace angio::angiogram

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "pipeline/stages/standing_picture.hpp"

namespace angio::pipeline {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// A square picture, of which a round shutter leaves a part open.
StandingPicture picture_of(int side, double pixel_mm, double open_radius) {
  StandingPicture picture;
  picture.frame = {{0.0, -800.0, 0.0},
                   {-0.5 * side * pixel_mm, 400.0, 0.0},
                   {pixel_mm, 0.0, 0.0},
                   {0.0, 0.0, -pixel_mm},
                   side,
                   side};
  for (int row = 0; row < side; ++row)
    for (int c = 0; c < side; ++c) {
      picture.pixels.push_back(float(c));
      picture.covered.push_back(
          std::hypot(c - 0.5 * (side - 1), row - 0.5 * (side - 1)) > open_radius ? 1 : 0);
    }
  return picture;
}

TEST(EvenOut, LeavesOpenWhatIsWhollyOpenAndNothingBesideThePicture) {
  // The fine one becomes 50 pixels of a side, and is widened by 15 to each.
  std::vector<StandingPicture> pictures{picture_of(100, 0.2, 55.0), picture_of(80, 0.4, 100.0)};
  const StandingPicture fine = pictures[0];
  even_out(pictures);
  ASSERT_EQ(pictures[0].frame.columns, 80);
  ASSERT_EQ(pictures[0].covered.size(), std::size_t{80 * 80});
  for (int row = 0; row < 80; ++row)
    for (int c = 0; c < 80; ++c) {
      bool is_open = true;
      for (int y = 2 * (row - 15); y < 2 * (row - 15) + 2; ++y)
        for (int x = 2 * (c - 15); x < 2 * (c - 15) + 2; ++x)
          is_open = is_open && x >= 0 && y >= 0 && x < 100 && y < 100 &&
                    fine.covered[std::size_t(y * 100 + x)] == 0;
      EXPECT_EQ(pictures[0].covered[std::size_t(row * 80 + c)], is_open ? 0 : 1)
          << c << ", " << row;
    }
  EXPECT_EQ(std::count(pictures[1].covered.begin(), pictures[1].covered.end(), 1), 0);
}

TEST(EvenOut, SaysOfAViewThatIsTooSmallWhatItsPixelsAre) {
  // Of a picture of over 1,024 pixels three become one, whatever the other view's are.
  std::vector<StandingPicture> pictures{picture_of(2100, 0.2, 40.0), picture_of(64, 0.2, 100.0)};
  EXPECT_THAT([&] { even_out(pictures); },
              ThrowsMessage<InputError>(HasSubstr("pixels of 0.6 mm (its own are of 0.2 mm, the "
                                                  "coarsest view's of 0.2 mm")));
}

}  // namespace
}  // namespace angio::pipeline

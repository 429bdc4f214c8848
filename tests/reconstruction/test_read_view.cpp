#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "reconstruction/detail/read_view.hpp"

namespace angio::reconstruction {
namespace {

using detail::open_field;

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

}  // namespace
}  // namespace angio::reconstruction

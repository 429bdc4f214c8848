#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "reconstruction/detail/vessel_lines.hpp"
#include "reconstruction/detail/view_vessel.hpp"

namespace angio::reconstruction {
namespace {

using namespace detail;

/// Lines of a picture: columns that run down it from a first to a last row, with their radius.
struct Upright {
  int column = 0, first = 0, last = 0;
  float radius = 0.0F;
};

VesselLines upright_lines(const std::vector<Upright>& all) {
  constexpr int kSide = 100;
  VesselLines lines{kSide, kSide, std::vector<float>(std::size_t(kSide * kSide), 0.0F)};
  for (const Upright& one : all)
    for (int row = one.first; row <= one.last; ++row)
      lines.radius[std::size_t(row * kSide + one.column)] = one.radius;
  return lines;
}

constexpr Upright kKept{40, 5, 95, 4.0F};

/// What is left out beside a kept vessel, where each line is a tube's but `edges`: bone, which
/// begins a radius before them and reaches to the picture's right.
OtherPixels other_pixels_beside(const std::vector<Upright>& tubes,
                                const std::vector<Upright>& edges = {}) {
  constexpr int kSide = 100;
  std::vector<Upright> all(tubes);
  all.push_back(kKept);
  ViewPicture kept;
  kept.lines = upright_lines({kKept});
  find_nearest(kept);
  kept.vessels.assign(std::size_t(kSide * kSide), 0.0F);
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column) {
      float& value = kept.vessels[std::size_t(row * kSide + column)];
      for (const Upright& tube : all) {
        const float away = float(column - tube.column);
        if (row >= tube.first && row <= tube.last)
          value += 2.0F * std::sqrt(std::max(0.0F, tube.radius * tube.radius - away * away));
      }
      for (const Upright& edge : edges)
        if (float(column) >= float(edge.column) - edge.radius) value += 10.0F;
    }
  all.insert(all.end(), edges.begin(), edges.end());
  return pixels_of_others(upright_lines(all), kept);
}

std::vector<char> others_beside(const std::vector<Upright>& tubes,
                                const std::vector<Upright>& edges = {}) {
  return other_pixels_beside(tubes, edges).covered;
}

TEST(PixelsOfOthers, AreThoseThatAnotherVesselCoversAndNoneBeyond) {
  const std::vector<char> covered = others_beside({{60, 5, 95, 4.0F}});
  for (int row = 10; row <= 90; ++row) {
    const auto at = [&](int column) { return covered[std::size_t(row * 100 + column)]; };
    for (int column = 56; column <= 64; ++column) EXPECT_EQ(at(column), 1) << column;
    // The kept vessel, and its background on both sides.
    for (int column = 30; column <= 50; ++column) EXPECT_EQ(at(column), 0) << column;
    EXPECT_EQ(at(70), 0);
  }
}

TEST(PixelsOfOthers, BehindWhichBoneBeginsAreLeftOutAsBeforeNone) {
  // The bone begins where the vessel's fall to that side is looked at. What reaches into the
  // background next to the kept vessel tells: an edge's pixels are not left out there.
  constexpr Upright kVessel{52, 5, 95, 4.0F};
  const std::vector<char> before_bone = others_beside({kVessel}, {{63, 5, 95, 4.0F}}),
                          before_none = others_beside({kVessel});
  for (int row = 10; row <= 90; ++row)
    for (int column = 0; column <= 55; ++column) {
      const auto at = std::size_t(row * 100 + column);
      EXPECT_EQ(before_bone[at], before_none[at]) << column;
      EXPECT_EQ(before_bone[at], column >= 46 ? 1 : 0) << column;
    }
}

TEST(PixelsOfOthers, AreNoneOfTheBackgroundNextToTheVesselWhereBoneBegins) {
  // To 1.6 radii and two pixels; a vessel's there are left out.
  constexpr Upright kBeside{54, 5, 95, 4.0F};
  const std::vector<char> of_edge = others_beside({}, {kBeside}),
                          of_vessel = others_beside({kBeside});
  for (int row = 10; row <= 90; ++row) {
    const auto at = [row](const std::vector<char>& covered, int column) {
      return covered[std::size_t(row * 100 + column)];
    };
    EXPECT_EQ(at(of_edge, 48), 0);
    EXPECT_EQ(at(of_vessel, 48), 1);
    EXPECT_EQ(at(of_edge, 50), 1);
  }
}

TEST(PixelsOfOthers, AreABranchsFromWhereItLeavesTheVessel) {
  std::vector<Upright> branch;
  for (int row = 18; row <= 80; ++row) branch.push_back({43 + (row - 18) / 2, row, row, 4.0F});
  const std::vector<char> covered = others_beside(branch);
  EXPECT_EQ(covered[std::size_t(20 * 100 + 40)], 1);
  EXPECT_EQ(covered[std::size_t(8 * 100 + 40)], 0);
  EXPECT_EQ(covered[std::size_t(50 * 100 + 40)], 0);
}

TEST(PixelsOfOthers, AreNoneNextToTheVesselWhereItHidesWhatALineIs) {
  const std::vector<char> covered = others_beside({{48, 5, 95, 4.0F}});
  for (int row = 10; row <= 90; ++row) EXPECT_EQ(covered[std::size_t(row * 100 + 46)], 0);
}

TEST(PixelsOfOthers, AreNotTheVesselsOwnWhereItIsSeenTwice) {
  // Broader, 1.25 of its radii away; a stub; and its own line alone.
  for (const std::vector<Upright>& others :
       {std::vector<Upright>{{48, 30, 60, 6.4F}}, {{60, 40, 46, 3.0F}}, {}}) {
    const std::vector<char> covered = others_beside(others);
    EXPECT_EQ(std::count(covered.begin(), covered.end(), 1), 0);
  }
}

TEST(PixelsOfOthers, AreNoneWhereTheyHideMoreThanHalfOfTheVessel) {
  // A broad one lies along the vessel, over its right half and more, and then leaves it.
  const auto along = [](int last) {
    std::vector<Upright> broad{{50, 5, last, 7.0F}};
    for (int column = 51; column < 90; ++column) broad.push_back({column, last, last, 7.0F});
    return other_pixels_beside(broad);
  };
  const OtherPixels short_one = along(40), long_one = along(90);
  EXPECT_GT(short_one.hidden_part, 0.1);
  EXPECT_LT(short_one.hidden_part, 0.5);
  EXPECT_FALSE(short_one.covered.empty());
  EXPECT_GT(long_one.hidden_part, 0.5);
  EXPECT_TRUE(long_one.covered.empty());
}

}  // namespace
}  // namespace angio::reconstruction

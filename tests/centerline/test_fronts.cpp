#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "centerline/detail/ends.hpp"
#include "centerline/detail/fronts.hpp"
#include "centerline/detail/lumen_voxels.hpp"
#include "core/units.hpp"
#include "testing/centerline/shapes.hpp"
#include "tests/centerline/tree_checks.hpp"

namespace angio::centerline {
namespace {

using test::add_noise;
using test::constant;
using test::grid_around;
using test::level_set_of;
using test::straight_tube;
using test::Tube;

/// A square of vessels with a branch: two ways to each place. Noise keeps paths from being as dear
/// as each other.
LumenVoxels square() {
  const std::vector<Tube> tubes{straight_tube({0, 0, 0}, {20, 0, 0}, constant(2.0)),
                                straight_tube({20, 0, 0}, {20, 0, 20}, constant(1.7)),
                                straight_tube({20, 0, 20}, {0, 0, 20}, constant(1.5)),
                                straight_tube({0, 0, 20}, {0, 0, 0}, constant(1.8)),
                                straight_tube({20, 0, 10}, {32, 0, 10}, constant(1.2))};
  Volume<float> level_set = level_set_of(tubes, grid_around(tubes, 0.4, 1.5));
  add_noise(level_set, 0.05, 3);
  return find_lumen_pieces(level_set).pieces.front();
}

void expect_same(const Front& a, const Front& b) {
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.length, b.length);
  EXPECT_EQ(a.previous, b.previous);
}

TEST(Front, RoundCutsIsThatOfAMarchFromTheSource) {
  LumenVoxels lumen = square();
  const int source = lumen.nearest({-1, 0, 0});
  Front front = march(lumen, source);
  std::mt19937 random(5);
  for (const Vec3& place : {Vec3{0, 0, 10}, Vec3{20, 0, 16}, Vec3{26, 0, 10}}) {
    // All links over a plane there; the branch beyond the last one is cut off.
    const Front before = front;
    for (int v = 0; v < lumen.count(); ++v)
      for (int n = 0; n < kNeighborCount; ++n) {
        const int w = lumen.neighbor(v, n);
        if (w < 0 || distance(lumen.position(v), place) > 4.0) continue;
        const int axis = place.x > 20.0 ? 0 : 2;
        if (lumen.position(v)[axis] < place[axis] && lumen.position(w)[axis] >= place[axis])
          lumen.cut(v, n);
      }
    march_round_cuts(lumen, front);
    EXPECT_NE(front.previous, before.previous);
    expect_same(front, march(lumen, source));
  }
  EXPECT_TRUE(std::isinf(front.length[std::size_t(lumen.nearest({32, 0, 10}))]));
  for (int cut = 0; cut < 2000; ++cut)  // here and there
    lumen.cut(int(random() % unsigned(lumen.count())), int(random() % kNeighborCount));
  march_round_cuts(lumen, front);
  expect_same(front, march(lumen, source));
}

/// The farthest voxel of a vessel that was cut off askew, by 50 degrees, is the corner of its rim.
TEST(Rims, HaveNoEndBesideTheirOwnAtTheCornerOfTheCap) {
  const double lean = std::tan(50.0 * units::kPi / 180.0);
  Volume<float> level_set =
      level_set_of({straight_tube({0, 0, 0}, {0, 0, 40}, constant(3.0))},
                   grid_around({straight_tube({0, 0, 0}, {0, 0, 40}, constant(3.0))}, 0.4, 1.5));
  const VolumeGeometry& grid = level_set.geometry;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = grid.lps_from_index({double(i), double(j), double(k)});
        const double beyond = (p.z - 30.0 - lean * p.x) / std::hypot(1.0, lean);
        level_set.at(i, j, k) = std::max(level_set.at(i, j, k), float(beyond));
      }
  const LumenVoxels lumen = find_lumen_pieces(level_set).pieces.front();
  const int source = lumen.nearest({0, 0, 1});
  const double askew = std::sqrt(std::hypot(1.0, lean));  // the radius of the rim's area
  const std::vector<Rim> rims{{source, {{0, 0, 1}, 3.0}},
                              {lumen.nearest({0, 0, 30}), {{0, 0, 30}, 3.0 * askew}}};
  Ends ends;
  ends.front = march(lumen, source);
  const int corner = lumen.nearest({2.8, 0, 30 + 2.7 * lean});
  ends.ends.push_back({corner, 4.0, false, false, lumen.position(corner)});
  std::vector<int> closed;
  take_rims(lumen, rims, true, source, ends, closed);
  ASSERT_EQ(ends.ends.size(), 1U);
  EXPECT_EQ(ends.ends[0].voxel, rims[1].voxel);
  EXPECT_TRUE(closed.empty());
}

/// Two holes in a closed surface, at the tips of two of its branches, do not make its other vessels
/// none; where most ends are open, what is closed and but three times as long as wide is no end.
TEST(Rims, AreNotTheOnlyEndsOfATreeThatIsClosed) {
  constexpr double kSide = 1.2, kLong = 9.0;  // mm; the trunk's wall is at 2.5
  std::vector<Tube> tree{straight_tube({0, 0, 0}, {0, 0, 60}, constant(2.5))};
  std::vector<Vec3> tips{{0, 0, 0}, {0, 0, 60}};
  for (int k = 0; k < 5; ++k) {
    const double angle = 1.2 * k, z = 10.0 + 9.0 * k;
    const Vec3 tip{kLong * std::cos(angle), kLong * std::sin(angle), z + 3.0};
    tree.push_back(straight_tube({0, 0, z}, tip, constant(kSide)));
    tips.push_back(tip);
  }
  LumenVoxels lumen =
      find_lumen_pieces(level_set_of(tree, grid_around(tree, 0.4, 1.5))).pieces.front();
  const auto ends_with = [&](std::size_t first, std::size_t last) {  // tips [first, last) are open
    std::vector<Rim> rims;
    for (std::size_t t = first; t < last; ++t)
      rims.push_back({lumen.nearest(tips[t]), {tips[t], kSide}});
    const int source = rims.front().voxel;
    std::vector<char> near_cut(std::size_t(lumen.count()), 0);
    Ends ends = find_ends(lumen, source, {}, 0.0, near_cut, {});
    std::vector<int> closed;
    take_rims(lumen, rims, false, source, ends, closed);
    return ends.ends.size();
  };
  EXPECT_EQ(ends_with(2, 4), tips.size() - 1);
  EXPECT_EQ(ends_with(0, 6), 5U);
}

}  // namespace
}  // namespace angio::centerline

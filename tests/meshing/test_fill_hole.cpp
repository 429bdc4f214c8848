#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "air_mesh/build/triangulate_loop.hpp"
#include "core/triangle_mesh.hpp"
#include "meshing/detail/mend_holes.hpp"
#include "meshing/detail/remesh_caps.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

/// Leaves the heap in pieces, so that what is allocated next lies in an order of its own.
class ScatteredHeap {
 public:
  explicit ScatteredHeap(unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::unique_ptr<char[]>> blocks(2000);
    for (auto& block : blocks) block = std::make_unique<char[]>(600 + random() % 12000);
    std::shuffle(blocks.begin(), blocks.end(), random);
    for (std::size_t i = 0; i < blocks.size(); i += 2) kept_.push_back(std::move(blocks[i]));
  }

 private:
  std::vector<std::unique_ptr<char[]>> kept_;
};

struct Loop {
  const char* name;
  int count;
  double (*height)(int i, int count);
};
void PrintTo(const Loop& loop, std::ostream* stream) { *stream << loop.name; }

double flat(int, int) { return 0.0; }
double zigzag(int i, int) { return i % 2 == 0 ? 0.1 : -0.1; }
double saddle(int i, int count) { return 0.3 * std::cos(4.0 * pi * i / count); }

std::vector<Vec3> points_of(const Loop& loop) {
  std::vector<Vec3> points;
  for (int i = 0; i < loop.count; ++i) {
    const double angle = 2.0 * pi * i / loop.count;
    points.push_back({std::cos(angle), std::sin(angle), loop.height(i, loop.count)});
  }
  return points;
}

/// Loops as regular as these have many triangulations that are equally good.
class RegularLoop : public testing::TestWithParam<Loop> {};

TEST_P(RegularLoop, IsClosedByOneTriangleLessThanTwoItHasCorners) {
  const std::vector<Vec3> points = points_of(GetParam());
  const TriangleMesh patch{points, air_mesh::triangulate_loop(points)};
  EXPECT_EQ(int(patch.triangles.size()), GetParam().count - 2);
  const auto loops = boundary_loops(patch);
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(int(loops[0].size()), GetParam().count);
}

TEST_P(RegularLoop, IsClosedTheSameWayWhereverMemoryLies) {
  const std::vector<Vec3> points = points_of(GetParam());
  const std::vector<Triangle> first = air_mesh::triangulate_loop(points);
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const ScatteredHeap heap(seed);
    ASSERT_EQ(air_mesh::triangulate_loop(points), first) << "seed " << seed;
  }
}

/// A tube without its caps.
TriangleMesh tube_between(const std::vector<Vec3>& ring) {
  TriangleMesh tube;
  const int n = int(ring.size());
  for (const double shift : {-2.0, 0.0})
    for (const Vec3& p : ring) tube.vertices.push_back({p.x, p.y, p.z + shift});
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    tube.triangles.push_back({i, j, n + j});
    tube.triangles.push_back({i, n + j, n + i});
  }
  return tube;
}

TEST_P(RegularLoop, IsFairedTheSameWayWhereverMemoryLies) {
  const TriangleMesh tube = tube_between(points_of(GetParam()));
  TriangleMesh first = tube;
  detail::fill_hole_fair(first, boundary_loops(tube)[0]);
  EXPECT_GT(first.triangles.size(), tube.triangles.size());
  EXPECT_EQ(boundary_loops(first).size(), 1u);
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const ScatteredHeap heap(seed);
    TriangleMesh again = tube;
    detail::fill_hole_fair(again, boundary_loops(tube)[0]);
    ASSERT_EQ(again.triangles, first.triangles) << "seed " << seed;
    ASSERT_EQ(again.vertices, first.vertices) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, RegularLoop,
                         testing::Values(Loop{"Flat", 24, flat}, Loop{"Zigzag", 24, zigzag},
                                         Loop{"Saddle", 24, saddle}, Loop{"LongFlat", 60, flat},
                                         Loop{"LongZigzag", 60, zigzag},
                                         Loop{"LongSaddle", 60, saddle}),
                         [](const auto& test_case) { return std::string(test_case.param.name); });

TEST(RemeshedCap, StaysAsItIsWhereARimsVertexHasNoTriangle) {
  TriangleMesh cap;
  constexpr int kRim = 12;
  for (int n = 0; n < kRim; ++n)
    cap.vertices.push_back({std::cos(2.0 * pi * n / kRim), std::sin(2.0 * pi * n / kRim), 0.0});
  cap.vertices.push_back({3.0, 0.0, 0.0});  // of a rim that touches this one
  cap.vertices.push_back({0.0, 0.0, 0.0});
  for (int n = 0; n < kRim; ++n) cap.triangles.push_back({n, (n + 1) % kRim, kRim + 1});
  std::vector<char> on_rim(cap.vertices.size(), 1);
  on_rim.back() = 0;
  const TriangleMesh result = detail::remeshed_cap(cap, on_rim);
  EXPECT_EQ(result.triangles, cap.triangles);
  EXPECT_EQ(result.vertices.size(), cap.vertices.size());
}

}  // namespace
}  // namespace angio::meshing

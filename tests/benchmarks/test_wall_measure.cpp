#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "testing/meshing/wall_measure.hpp"

namespace angio::benchmarks {
namespace {

using std::numbers::pi;

constexpr int kAround = 16, kRows = 41;
constexpr double kStep = 0.1;

/// An open tube along z of rows of vertices, with the normals out.
TriangleMesh tube(const std::function<double(double angle, int row)>& radius) {
  TriangleMesh mesh;
  for (int row = 0; row < kRows; ++row)
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2.0 * pi * k / kAround, r = radius(angle, row);
      mesh.vertices.push_back({r * std::cos(angle), r * std::sin(angle), kStep * row});
    }
  for (int row = 0; row + 1 < kRows; ++row)
    for (int k = 0; k < kAround; ++k) {
      const int a = row * kAround + k, b = row * kAround + (k + 1) % kAround;
      mesh.triangles.push_back({a, b, b + kAround});
      mesh.triangles.push_back({a, b + kAround, a + kAround});
    }
  return mesh;
}

Unevenness unevenness_of(const TriangleMesh& mesh) {
  std::vector<TubePoint> points;
  for (const Vec3& p : mesh.vertices) points.push_back({p, {0.0, 0.0, 1.0}});
  return unevenness(points);
}

TEST(EdgeBends, OfAPrismAreItsCornersAndOfItsInsideTheSameHollow) {
  TriangleMesh prism = tube([](double, int) { return 1.0; });
  std::vector<double> bends = edge_bends(prism);
  EXPECT_NEAR(*std::max_element(bends.begin(), bends.end()), 360.0 / kAround, 1e-9);
  EXPECT_NEAR(*std::min_element(bends.begin(), bends.end()), 0.0, 1e-9);  // diagonals, rims
  for (Triangle& t : prism.triangles) std::swap(t[0], t[1]);
  bends = edge_bends(prism);
  EXPECT_NEAR(*std::min_element(bends.begin(), bends.end()), -360.0 / kAround, 1e-9);
}

TEST(TriangleAspects, AreOneIfEquilateralAndGrowWithTheStretch) {
  const double h = 0.5 * std::numbers::sqrt3;
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}, {5, 0, 0}, {2.5, h, 0}},
                          {{0, 1, 2}, {0, 3, 4}}};
  const std::vector<double> aspects = triangle_aspects(mesh);
  EXPECT_NEAR(aspects[0], 1.0, 1e-12);
  EXPECT_NEAR(aspects[1], 5.0, 1e-12);
}

TEST(Unevenness, IsNextToNothingOfConesWaistsAndOvals) {
  EXPECT_LT(unevenness_of(tube([](double, int) { return 0.3; })).mm, 1e-9);
  EXPECT_LT(unevenness_of(tube([](double, int row) { return 0.5 + 0.01 * row; })).mm, 1e-9);
  const auto waist = [](double, int row) {
    return 1.0 - 0.6 * std::cos(0.25 * pi * (kStep * row - 2.0));
  };
  EXPECT_LT(unevenness_of(tube(waist)).mm, 2e-3);
  const auto oval = [](double angle, int) { return 1.0 + 0.1 * std::cos(2.0 * angle); };
  EXPECT_LT(unevenness_of(tube(oval)).mm, 5e-3);  // of 0.1 mm: no quadratic
}

// Rows that stand in and out by h are off their mean by h, whatever the tube's width. The fit goes
// along with a row by what the middle row weighs in it, less than a fifth.
TEST(Unevenness, IsTheHeightOfRowsThatStandInAndOut) {
  for (const double width : {0.3, 1.5}) {
    const double h = 0.02;
    const Unevenness found =
        unevenness_of(tube([&](double, int row) { return width + (row % 2 == 0 ? h : -h); }));
    EXPECT_NEAR(found.mm / h, 1.0, 0.2) << width;
    EXPECT_NEAR(found.percent / (100.0 * h / width), 1.0, 0.2) << width;
  }
}

TEST(SectionOf, AnOvalTubeHasItsAxesAndArea) {
  const auto oval = [](double angle, int) {
    return 1.0 / std::hypot(std::cos(angle) / 2.0, std::sin(angle) / 1.0);
  };
  const TubeSection section = section_of(tube(oval), {0.1, 0.0, 2.03}, {0.0, 0.0, 1.0});
  EXPECT_NEAR(section.widest_mm, 4.0, 5e-3);  // widths are looked for at each degree
  EXPECT_NEAR(section.narrowest_mm, 2.0, 5e-3);
  EXPECT_NEAR(section.area_mm2, 2.0 * pi, 0.1 * pi);  // a polygon has less
  EXPECT_LT(section.roundness, 0.9);
  const TubeSection round =
      section_of(tube([](double, int) { return 2.0; }), {0.0, 0.0, 2.03}, {0.0, 0.0, 1.0});
  EXPECT_NEAR(round.roundness, pi / (kAround * std::tan(pi / kAround)), 1e-3);
}

TEST(SectionOf, NothingIsNothing) {
  const TubeSection section =
      section_of(tube([](double, int) { return 1.0; }), {0.0, 0.0, 99.0}, {0.0, 0.0, 1.0});
  EXPECT_EQ(section.area_mm2, 0.0);
}

}  // namespace
}  // namespace angio::benchmarks

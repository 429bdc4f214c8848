#include <gtest/gtest.h>

#include "meshing/meshing.hpp"
#include "testing/shapes.hpp"

namespace angio::meshing {
namespace {

TEST(Intersections, OfSurfacesApartAreNone) {
  const auto a = tests::make_box({0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(count_intersections(a, tests::make_box({1.001, 0, 0}, {1, 1, 1})), 0);
  EXPECT_EQ(count_intersections(a, tests::make_box({0.2, 0.2, 0.2}, {0.5, 0.5, 0.5})), 0);
}

TEST(Intersections, OfSurfacesThatTouchInOnePointAreFound) {
  const TriangleMesh a{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const TriangleMesh b{{{0.25, 0.25, 0.0}, {0, 0, 1}, {1, 0, 1}}, {{0, 1, 2}}};
  EXPECT_EQ(count_intersections(a, b), 1);
}

TEST(Intersections, OfBoxesThatOverlapAreFound) {
  const auto a = tests::make_box({0, 0, 0}, {1, 1, 1});
  EXPECT_GT(count_intersections(a, tests::make_box({0.5, 0.3, 0.4}, {1, 1, 1})), 0);
}

TEST(SelfIntersections, OfASphereAreNone) {
  EXPECT_EQ(count_self_intersections(tests::make_sphere({0.1, 0.2, 0.3}, 2.0, 3)), 0);
}

TEST(SelfIntersections, OfTwoPiecesThatCrossAreFound) {
  TriangleMesh mesh{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0.5, 0.5, -1}, {0.5, 0.5, 1}, {3, 3, 0}},
                    {{0, 1, 2}, {3, 4, 5}}};
  EXPECT_EQ(count_self_intersections(mesh), 1);
}

TEST(SelfIntersections, OfTrianglesThatOnlyShareACornerAreNone) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0.5}, {0, -1, 0.5}},
                    {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_EQ(count_self_intersections(mesh), 0);
}

TEST(SelfIntersections, OfTrianglesThatShareACornerAndCrossAreFound) {
  TriangleMesh mesh{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 1, -1}, {1, 0.5, 1}},
                    {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_EQ(count_self_intersections(mesh), 1);
}

TEST(SelfIntersections, OfTrianglesFoldedOntoEachOtherAreFound) {
  TriangleMesh flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.7, 0}}, {{0, 1, 2}, {1, 0, 3}}};
  EXPECT_EQ(count_self_intersections(flat), 1);
  flat.vertices[3] = {0.2, -0.7, 0};
  EXPECT_EQ(count_self_intersections(flat), 0);
}

TEST(SelfIntersections, CountADegenerateTriangle) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}};
  EXPECT_EQ(count_self_intersections(mesh), 1);
}

}  // namespace
}  // namespace angio::meshing

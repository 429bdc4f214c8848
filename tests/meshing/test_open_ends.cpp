#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "meshing/detail/lumen_draft.hpp"
#include "meshing/detail/open_ends.hpp"
#include "meshing/detail/pieces.hpp"
#include "meshing/detail/triangle_blocks.hpp"
#include "testing/meshing/analytic_vessels.hpp"
#include "testing/shapes.hpp"

namespace angio::meshing {
namespace {

using detail::EndOpener;
using detail::Plane;

Vec3 random_point(std::mt19937& random, double half) {
  std::uniform_real_distribution<double> within(-half, half);
  const double x = within(random), y = within(random);
  return {x, y, within(random)};
}

bool is_cut(const TriangleMesh& mesh, const Triangle& t, const Plane& plane) {
  int far_count = 0;
  for (const int v : t) far_count += plane.signed_distance(mesh.vertices[std::size_t(v)]) > 0.0;
  return far_count == 1 || far_count == 2;
}

bool has_corner_in(const TriangleMesh& mesh, const Triangle& t, const detail::Ball& ball) {
  return std::any_of(t.begin(), t.end(), [&](int v) {
    return distance(mesh.vertices[std::size_t(v)], ball.middle) <= ball.radius;
  });
}

TEST(TriangleBlocks, FindAllThatAPlaneCutsInABall) {
  std::mt19937 random(7);
  TriangleMesh soup = tests::make_sphere({3, -2, 1}, 4.0, 5);
  for (int n = 0; n < 300; ++n) {  // long and short ones besides
    const Vec3 at = random_point(random, 8.0);
    const double size = n % 10 == 0 ? 12.0 : 0.3;
    for (int c = 0; c < 3; ++c) soup.vertices.push_back(at + random_point(random, size));
    const int last = int(soup.vertices.size()) - 1;
    soup.triangles.push_back({last - 2, last - 1, last});
  }
  const detail::TriangleBlocks blocks(soup);
  for (int n = 0; n < 200; ++n) {
    const Plane plane{random_point(random, 6.0), normalized(random_point(random, 1.0))};
    const detail::Ball ball{random_point(random, 6.0), 0.02 * n};
    const std::vector<int> found = blocks.near_cut(plane, ball);
    const std::set<int> distinct(found.begin(), found.end());
    EXPECT_EQ(distinct.size(), found.size());
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
      const Triangle& corners = soup.triangles[t];
      if (!is_cut(soup, corners, plane) || !has_corner_in(soup, corners, ball)) continue;
      EXPECT_TRUE(distinct.contains(int(t))) << t;
    }
  }
}

TEST(TriangleBlocks, LookAtFewOthers) {
  const TriangleMesh sphere = tests::make_sphere({0, 0, 0}, 10.0, 7);  // 131,072 triangles
  const Plane plane{{0.1, 0.2, 9.0}, normalized(Vec3{0.2, 0.3, 1.0})};
  const detail::Ball ball{plane.origin, 8.0};
  const auto cut_count =
      std::count_if(sphere.triangles.begin(), sphere.triangles.end(), [&](const Triangle& t) {
        return is_cut(sphere, t, plane) && has_corner_in(sphere, t, ball);
      });
  ASSERT_GT(cut_count, 300);
  EXPECT_LT(std::ptrdiff_t(detail::TriangleBlocks(sphere).near_cut(plane, ball).size()),
            8 * cut_count);
}

/// A tube along z from 0 to 40, closed by flat ends.
TriangleMesh closed_tube() { return detail::closed_copy(tests::make_tube(2.0, 40.0, 80, 32)); }

TEST(EndOpener, CutsWhatLiesBeyondTheSectionAndNoMore) {
  const TriangleMesh tube = closed_tube();
  EndOpener opener(tube, {{0, 0, 0}, {0, 0, 40}});
  const Plane plane{{0.1, 0.2, 38.1}, normalized(Vec3{0.1, 0.0, 1.0})};
  for (int again = 0; again < 2; ++again) {  // nothing is left over from one call to the next
    const EndOpener::Cut cut = opener.best_cut({plane}, 2.0, 1);
    ASSERT_EQ(cut.verdict, EndOpener::Verdict::sound);
    const std::set<int> crossed(cut.triangles.begin(), cut.triangles.end());
    const std::set<int> beyond(cut.beyond.begin(), cut.beyond.end());
    EXPECT_EQ(beyond.size(), cut.beyond.size());
    for (std::size_t t = 0; t < tube.triangles.size(); ++t)
      EXPECT_EQ(crossed.contains(int(t)), is_cut(tube, tube.triangles[t], plane)) << t;
    for (std::size_t v = 0; v < tube.vertices.size(); ++v)
      EXPECT_EQ(beyond.contains(int(v)), plane.signed_distance(tube.vertices[v]) > 0.0) << v;
    EXPECT_NEAR(cut.roundness, 1.0, 0.02);
  }
  EndOpener::Cut cut = opener.best_cut({plane}, 2.0, 1);
  const auto crossed_count = std::ptrdiff_t(cut.triangles.size());
  opener.plan(std::move(cut));
  TriangleMesh open;
  std::vector<int> rim(tube.vertices.size(), -1);
  opener.apply(open, rim);
  EXPECT_EQ(boundary_loops(open).size(), 1U);
  EXPECT_EQ(std::count(rim.begin(), rim.end(), 1), crossed_count);
  // What is gone cannot be cut again.
  EXPECT_EQ(opener.best_cut({plane}, 2.0, 1).verdict, EndOpener::Verdict::no_end);
}

TEST(EndOpener, TakesNoOtherTipAway) {
  const TriangleMesh tube = closed_tube();
  EndOpener opener(tube, {{0, 0, 0}, {0, 0, 40}, {2, 0, 38}});
  const Plane inside{{0, 0, 35}, {0, 0, 1}}, outside{{0, 0, 39}, {0, 0, 1}};
  EXPECT_EQ(opener.best_cut({inside}, 2.0, 1).verdict, EndOpener::Verdict::no_end);
  EXPECT_EQ(opener.best_cut({inside, outside}, 2.0, 1).verdict, EndOpener::Verdict::sound);
}

TEST(OpenSurface, KeepsAnUnevenRimWhereNoPlaneOpensTheEnd) {
  // Any plane across the line at the inlet would take another end away, which lies in its mouth.
  TriangleMesh tube = tests::make_tube(2.0, 40.0, 80, 32);
  for (Vec3& v : tube.vertices)
    if (v.z < 1e-9) v.z = 0.2 * std::cos(2.0 * std::atan2(v.y, v.x)) - 0.2;
  std::vector<Vec3> points;
  for (int i = 0; i <= 80; ++i) points.push_back({0.0, 0.0, 0.5 * i});
  CenterlineTree tree;
  tree.paths.push_back(test::make_path(0, points, std::vector<double>(points.size(), 2.0)));
  const detail::LineEnd inlet{{0, 0, 0}, 2.0, 0, true}, outlet{{0, 0, 40}, 2.0, 0, false},
      in_the_mouth{{2, 0, 0}, 0.3, 0, true};
  std::vector<std::string> warnings;
  const detail::OpenedSurface opened =
      detail::open_surface(tube, tree, {inlet, outlet, in_the_mouth}, warnings);
  ASSERT_EQ(boundary_loops(opened.draft.mesh).size(), 2U);
  const Plane plane = opened.draft.rim_planes.at(0);
  int count = 0;
  for (std::size_t v = 0; v < opened.draft.rim.size(); ++v) {
    if (opened.draft.rim[v] != 0) continue;
    ++count;
    EXPECT_NEAR(plane.signed_distance(opened.draft.mesh.vertices[v]), 0.0, 1e-9);
  }
  EXPECT_EQ(count, 32);
}

TEST(EndOpener, NoEndIsWhatGoesOnOrIsTooFarAcross) {
  const TriangleMesh tube = closed_tube();
  EndOpener opener(tube, {{0, 0, 40}});
  // Sixteen radii further the tube still goes on.
  EXPECT_EQ(opener.best_cut({{{0, 0, 5}, {0, 0, 1}}}, 2.0, 0).verdict, EndOpener::Verdict::no_end);
  EXPECT_EQ(opener.best_cut({{{0, 0, 12}, {0, 0, 1}}}, 2.0, 0).verdict, EndOpener::Verdict::sound);
  // Four radii of 0.4 mm do not reach the wall.
  EXPECT_EQ(opener.best_cut({{{0, 0, 38}, {0, 0, 1}}}, 0.4, 0).verdict,
            EndOpener::Verdict::no_section);
  EXPECT_EQ(opener.best_cut({{{0, 0, 38}, {0, 0, 1}}}, 0.6, 0).verdict, EndOpener::Verdict::sound);
  // Beside the wall there is none around the plane's origin.
  EXPECT_EQ(opener.best_cut({{{3, 0, 38}, {0, 0, 1}}}, 2.0, 0).verdict,
            EndOpener::Verdict::no_section);
}

}  // namespace
}  // namespace angio::meshing

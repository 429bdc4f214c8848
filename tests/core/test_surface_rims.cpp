#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "core/surface_rims.hpp"
#include "core/units.hpp"
#include "testing/shapes.hpp"

namespace angio {
namespace {

/// The triangles whose middle is kept.
TriangleMesh cut(TriangleMesh mesh, const std::function<bool(const Vec3&)>& keep) {
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    return !keep((mesh.vertices[std::size_t(t[0])] + mesh.vertices[std::size_t(t[1])] +
                  mesh.vertices[std::size_t(t[2])]) /
                 3.0);
  });
  return mesh;
}

/// The rim that is nearest to a place.
SurfaceRim rim_at(const TriangleMesh& mesh, const Vec3& place) {
  SurfaceRim nearest;
  double least = 1e300;
  for (const SurfaceRim& rim : surface_rims(mesh)) {
    if (distance(rim.centre, place) >= least) continue;
    least = distance(rim.centre, place);
    nearest = rim;
  }
  return nearest;
}

TEST(SurfaceRims, AreThePlacesAndWidthsOfATubesEnds) {
  const auto rims = surface_rims(tests::make_tube(1.5, 10.0, 21, 64));
  ASSERT_EQ(rims.size(), 2U);
  for (const SurfaceRim& rim : rims) {
    EXPECT_NEAR(rim.diameter_mm, 3.0, 0.01);
    EXPECT_NEAR(rim.unevenness_mm, 0.0, 1e-12);
    EXPECT_NEAR(rim.wall_along, 1.0, 0.01);
    const double end = rim.centre.z > 5.0 ? 1.0 : -1.0;
    EXPECT_NEAR(distance(rim.centre, {0, 0, 5.0 + 5.0 * end}), 0.0, 1e-9);
    EXPECT_NEAR(distance(rim.normal, {0, 0, end}), 0.0, 1e-9);
  }
}

TEST(SurfaceRims, OfATubeCutAslantAreEndsToo) {
  // The ellipse has half axes r and r / cos(tilt); the pull is that of the tube.
  for (const double tilt : {30.0, 45.0, 60.0}) {
    TriangleMesh tube = tests::make_tube(1.0, 8.0, 33, 64);
    const double slope = std::tan(tilt * units::kPi / 180.0);
    for (Vec3& v : tube.vertices) v.z += slope * v.x;
    for (const SurfaceRim& rim : surface_rims(tube)) {
      const double stretch = std::sqrt(1.0 / std::cos(tilt * units::kPi / 180.0));
      EXPECT_NEAR(rim.diameter_mm, 2.0 * stretch, 0.02);
      EXPECT_GT(rim.wall_along, 0.5);
    }
  }
}

TEST(SurfaceRims, OfAJaggedCutAreEndsToo) {
  TriangleMesh tube = tests::make_tube(1.0, 8.0, 65, 48);
  std::mt19937 random(3);
  std::vector<double> wave;
  for (int i = 0; i < 48; ++i) wave.push_back(0.4 * double(random() % 1000) / 1000.0);
  tube = cut(std::move(tube), [&](const Vec3& p) {
    const double angle = std::atan2(p.y, p.x) / (2.0 * units::kPi) + 0.5;
    return p.z < 7.0 - wave[std::size_t(angle * 47.999)];
  });
  EXPECT_GT(rim_at(tube, {0, 0, 7}).wall_along, 0.8);
}

TEST(SurfaceRims, ThatLeanInwardsAreEndsToo) {
  // The edge of a rounded cap is left: a quarter circle, so that the last triangles lie across.
  TriangleMesh tube = tests::make_tube(1.5, 10.0, 161, 96);
  for (Vec3& v : tube.vertices) {
    const double beyond = std::clamp((v.z - 9.7) / 0.3, 0.0, 1.0);
    const double shrink = 1.0 - 0.2 * (1.0 - std::sqrt(1.0 - beyond * beyond));
    v.x *= shrink;
    v.y *= shrink;
  }
  EXPECT_GT(rim_at(tube, {0, 0, 10}).wall_along, 0.9);
}

TEST(SurfaceRims, InAFlatLipThatACapHasLeftAreEndsToo) {
  // The last rings lie in the plane of the cut: a lip, wider to one side, as a hole in a cap
  // leaves.
  TriangleMesh tube = tests::make_tube(1.5, 10.0, 161, 96);
  for (Vec3& v : tube.vertices) {
    const double beyond = std::max(v.z - 9.5, 0.0) / 0.5;
    const double width = 0.4 + 0.05 * std::cos(std::atan2(v.y, v.x));  // mm
    const double shrink = 1.0 - beyond * width / 1.5;
    v.x *= shrink;
    v.y *= shrink;
    v.z = std::min(v.z, 9.5);
  }
  EXPECT_GT(rim_at(tube, {0, 0, 9.5}).wall_along, 0.8);
}

TEST(SurfaceRims, OfAMouthThatFlaresAreEndsToo) {
  // The last 3 mm open as a quarter of an ellipse, so that the rim lies across, three times as wide
  // as the tube.
  TriangleMesh tube = tests::make_tube(1.8, 20.0, 161, 48);
  for (Vec3& v : tube.vertices) {
    const double beyond = std::max(v.z - 17.0, 0.0) / 3.0;
    const double stretch = 1.0 + 1.95 * (1.0 - std::sqrt(1.0 - beyond * beyond));
    v.x *= stretch;
    v.y *= stretch;
  }
  EXPECT_GT(rim_at(tube, {0, 0, 20}).wall_along, 0.8);
}

TEST(SurfaceRims, OfAWideHoleInATubesSideAreNone) {
  for (const double radius : {1.0, 1.1}) {  // of a tube of radius 1.5
    const TriangleMesh tube = cut(tests::make_tube(1.5, 20.0, 321, 160), [&](const Vec3& p) {
      return p.x < 0.0 || std::hypot(p.y, p.z - 10.0) > radius;
    });
    EXPECT_LT(rim_at(tube, {1.5, 0, 10}).wall_along, 0.5) << radius;
  }
}

TEST(SurfaceRims, OfTheInnerSideOfAWallPullTheOtherWay) {
  TriangleMesh tube = tests::make_tube(1.5, 10.0, 21, 64);
  for (Triangle& t : tube.triangles) std::swap(t[0], t[1]);
  for (const SurfaceRim& rim : surface_rims(tube)) EXPECT_LT(rim.wall_along, -0.95);
}

TEST(SurfaceRims, OfAHoleInATubesSideAreNone) {
  for (const double radius : {0.3, 0.6, 0.9}) {  // of a tube of radius 1.5: a / 2R = 0.1 to 0.3
    const TriangleMesh tube = cut(tests::make_tube(1.5, 10.0, 161, 160), [&](const Vec3& p) {
      return p.x < 0.0 || std::hypot(p.y, p.z - 5.0) > radius;
    });
    const SurfaceRim hole = rim_at(tube, {1.5, 0, 5});
    EXPECT_NEAR(hole.diameter_mm, 2.0 * radius, 0.1);
    // At the rim, or a quarter of the radius farther.
    EXPECT_GT(hole.wall_along, radius / 3.0 - 0.08);
    EXPECT_LT(hole.wall_along, 1.25 * radius / 3.0 + 0.08);
    EXPECT_LT(hole.wall_along, 0.5);
  }
}

TEST(SurfaceRims, OfABallCutOpenPullByTheSineOfTheCut) {
  for (const double degrees : {15.0, 30.0, 60.0, 90.0}) {
    const double angle = degrees * units::kPi / 180.0;
    const TriangleMesh bowl = cut(tests::make_sphere({0, 0, 0}, 2.0, 6),
                                  [&](const Vec3& p) { return p.z < 2.0 * std::cos(angle); });
    EXPECT_NEAR(rim_at(bowl, {0, 0, 2}).wall_along, std::sin(angle), 0.08);
  }
}

TEST(SurfaceRims, OfAClosedSurfaceAreNone) {
  EXPECT_TRUE(surface_rims(tests::make_sphere({0, 0, 0}, 1.0, 3)).empty());
}

}  // namespace
}  // namespace angio

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "centerline/detail/flat_caps.hpp"
#include "core/triangle_mesh.hpp"
#include "core/units.hpp"
#include "testing/shapes.hpp"

// Flat ends of closed surfaces, which are outlets as open rims are.
namespace angio::centerline {
namespace {

TEST(FlatCaps, AreRemovedFromATubeAndNotFromASphere) {
  const TriangleMesh tube = tests::make_tube(1.5, 20.0, 60, 32);
  const TriangleMesh sphere = tests::make_sphere({0, 0, 0}, 3.0, 4);
  EXPECT_EQ(remove_flat_caps(sphere).triangles.size(), sphere.triangles.size());
  // A tube with its rims closed by rings of triangles around their middles.
  TriangleMesh closed = tube;
  for (const std::vector<int>& rim : boundary_loops(tube)) {
    Vec3 middle;
    for (const int v : rim) middle += tube.vertices[std::size_t(v)] / double(rim.size());
    const int center = int(closed.vertices.size());
    closed.vertices.push_back(middle);
    for (std::size_t i = 0; i < rim.size(); ++i)
      closed.triangles.push_back({rim[i], rim[(i + 1) % rim.size()], center});
  }
  EXPECT_EQ(surface_topology(closed).boundary_edge_count, 0);
  EXPECT_EQ(boundary_loops(remove_flat_caps(closed)).size(), 2U);
}

TEST(FlatCaps, AreKnownOfAThinVesselBesideCoarserWalls) {
  constexpr int kAround = 16;
  constexpr double kRadius = 0.4, kLength = 4.0;  // the thin one; the wide one's edges are longer
  TriangleMesh mesh = tests::make_sphere({20, 0, 0}, 10.0, 3);
  const int first = int(mesh.vertices.size());
  for (const double z : {0.0, kLength})
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2.0 * units::kPi * k / kAround;
      mesh.vertices.push_back({kRadius * std::cos(angle), kRadius * std::sin(angle), z});
    }
  for (const double z : {0.0, kLength}) mesh.vertices.push_back({0, 0, z});
  for (int k = 0; k < kAround; ++k) {
    const int a = first + k, b = first + (k + 1) % kAround;
    mesh.triangles.push_back({a, b, b + kAround});
    mesh.triangles.push_back({a, b + kAround, a + kAround});
    mesh.triangles.push_back({first + 2 * kAround, b, a});
    mesh.triangles.push_back({first + 2 * kAround + 1, a + kAround, b + kAround});
  }
  EXPECT_EQ(boundary_loops(remove_flat_caps(mesh)).size(), 2U);
}

TEST(FlatCaps, OfCoarseTubesArePolygonsAndNoRectangleIsOne) {
  for (const int around : {6, 8, 12}) {
    // Rings half as far apart as the rim's corners: the mean edge is no longer than those of the
    // rim.
    const double edge = 2.0 * std::sin(units::kPi / around);
    const int rings = 2 + int(20.0 / edge);
    TriangleMesh tube = tests::make_tube(1.0, 20.0, rings, around);
    for (const std::vector<int>& rim : boundary_loops(TriangleMesh(tube)))
      for (std::size_t i = 1; i + 1 < rim.size(); ++i)
        tube.triangles.push_back({rim[0], rim[i], rim[i + 1]});
    ASSERT_TRUE(surface_topology(tube).is_closed());
    EXPECT_EQ(boundary_loops(remove_flat_caps(tube)).size(), 2U) << around;
  }
  // The steps of a staircase of cubes have sharp edges all round, too.
  std::vector<std::array<int, 3>> stairs;
  for (int k = 0; k < 3; ++k)
    for (int i = k; i < 7 - k; ++i)
      for (int j = k; j < 7 - k; ++j)
        if (k < 2 || (i > 1 && i < 5 && j > 1 && j < 5)) stairs.push_back({i, j, k});
  const TriangleMesh steps = tests::surface_of_cubes(stairs);
  const TriangleMesh left = remove_flat_caps(steps);
  const auto on_top = [](const TriangleMesh& mesh) {
    return std::count_if(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
      return std::all_of(t.begin(), t.end(),
                         [&](int v) { return mesh.vertices[std::size_t(v)].z == 3.0; });
    });
  };
  EXPECT_EQ(on_top(steps), 18);
  EXPECT_EQ(on_top(left), 18);
}

TEST(FlatCaps, WithRoundedEdgesAreFlatEndsAndRoundTipsAndWallsAreNone) {
  EXPECT_TRUE(find_flat_ends(tests::make_sphere({0, 0, 0}, 3.0, 4)).empty());
  // A tube of radius 3 whose caps have edges rounded by a radius of 0.9, along its profile.
  const double round = 0.9;
  std::vector<std::array<double, 2>> profile;  // distance from the axis, z
  for (double r = 0.3; r < 3.0 - round; r += 0.3) profile.push_back({r, 0.0});
  for (double a = 0.0; a <= 90.0; a += 15.0)
    profile.push_back({3.0 - round + round * std::sin(a * units::kPi / 180.0),
                       round - round * std::cos(a * units::kPi / 180.0)});
  for (double z = 1.2; z < 10.01; z += 0.3) profile.push_back({3.0, z});
  for (std::size_t i = profile.size(); i-- > 0;)
    if (profile[i][1] < 9.99) profile.push_back({profile[i][0], 20.0 - profile[i][1]});
  const int around = 48;
  TriangleMesh tube;
  for (const auto& [r, z] : profile)
    for (int k = 0; k < around; ++k) {
      const double angle = 2.0 * units::kPi * k / around;
      tube.vertices.push_back({r * std::cos(angle), r * std::sin(angle), z});
    }
  const int rings = int(profile.size()), first = rings * around, last = first + 1;
  tube.vertices.push_back({0, 0, 0});
  tube.vertices.push_back({0, 0, 20});
  for (int k = 0; k < around; ++k) {
    const int next = (k + 1) % around;
    for (int i = 0; i + 1 < rings; ++i) {
      tube.triangles.push_back({i * around + k, i * around + next, (i + 1) * around + next});
      tube.triangles.push_back({i * around + k, (i + 1) * around + next, (i + 1) * around + k});
    }
    tube.triangles.push_back({first, next, k});
    tube.triangles.push_back({last, (rings - 1) * around + k, (rings - 1) * around + next});
  }
  const std::vector<OpenRim> ends = find_flat_ends(tube);
  ASSERT_EQ(ends.size(), 2U);
  for (const OpenRim& end : ends) {
    EXPECT_LT(std::hypot(end.middle.x, end.middle.y), 0.1);
    EXPECT_NEAR(std::abs(end.middle.z - 10.0), 10.0, 0.1);
    EXPECT_NEAR(end.radius, 3.0, 0.3);
  }
}

}  // namespace
}  // namespace angio::centerline

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/surface_rims.hpp"
#include "meshing/detail/pieces.hpp"
#include "meshing/detail/unite_parts.hpp"
#include "meshing/detail/winding.hpp"
#include "meshing/meshing.hpp"
#include "meshing/repair_surface.hpp"
#include "testing/shapes.hpp"

/// Parts of known volume, put together in ways whose union is known too: none may be lost.
namespace angio::meshing {
namespace {

using std::numbers::pi;
using testing::Contains;
using testing::HasSubstr;

std::vector<std::string> texts(const RepairedSurface& repaired) {
  std::vector<std::string> list;
  for (const SurfaceRepair& repair : repaired.repairs) list.push_back(to_text(repair));
  return list;
}

void expect_sound(const RepairedSurface& repaired, double volume, double tolerance) {
  const SurfaceTopology topology = surface_topology(repaired.mesh);
  EXPECT_TRUE(topology.is_closed());
  EXPECT_EQ(topology.component_count, 1);
  EXPECT_EQ(count_self_intersections(repaired.mesh), 0);
  EXPECT_NEAR(enclosed_volume(repaired.mesh) / volume, 1.0, tolerance);
}

/// A tube from one point to another, closed by flat ends or open.
TriangleMesh tube_between(const Vec3& from, const Vec3& to, double radius, bool closed,
                          int sides = 24) {
  const double length = distance(from, to);
  TriangleMesh tube =
      tests::make_tube(radius, length, std::max(2, int(length / (0.5 * radius))), sides);
  const Vec3 axis = (to - from) / length;
  const Vec3 u = any_perpendicular(axis);
  const Vec3 v = cross(axis, u);
  for (Vec3& p : tube.vertices) p = from + p.x * u + p.y * v + p.z * axis;
  return closed ? detail::closed_copy(tube) : tube;
}

/// Volume of two balls of the same radius, a distance apart: twice a ball less the lens
/// pi (4 r + d) (2 r - d)^2 / 12.
double two_balls(double r, double d) {
  return 8.0 / 3.0 * pi * r * r * r - pi * (4.0 * r + d) * (2.0 * r - d) * (2.0 * r - d) / 12.0;
}

/// A trunk along z and ten branches that begin on its axis, each a closed part of its own.
std::vector<TriangleMesh> tree_of_branches(bool closed, double& trunk_volume) {
  std::vector<TriangleMesh> parts{tube_between({0, 0, 0}, {0, 0, 60}, 2.0, closed)};
  trunk_volume = enclosed_volume(detail::closed_copy(parts[0]));
  for (int i = 0; i < 10; ++i) {
    const double angle = 2.4 * i;
    const Vec3 from{0.0, 0.0, 5.0 + 5.0 * i};
    const Vec3 out = normalized(Vec3{std::cos(angle), std::sin(angle), 0.6});
    parts.push_back(tube_between(from, from + 15.0 * out, 0.9, closed));
  }
  return parts;
}

TEST(Winding, CountsHowManyPartsAPlaceIsIn) {
  const TriangleMesh both = detail::joined(
      {tests::make_sphere({0, 0, 0}, 1.0, 4), tests::make_sphere({1, 0, 0}, 1.0, 4)});
  const detail::Winding winding(both);
  EXPECT_EQ(winding.at({0.5, 0.0, 0.0}), 2);
  EXPECT_EQ(winding.at({-0.5, 0.0, 0.0}), 1);
  EXPECT_EQ(winding.at({1.5, 0.1, 0.2}), 1);
  EXPECT_EQ(winding.at({2.5, 0.0, 0.0}), 0);
  EXPECT_EQ(winding.at({0.5, 0.95, 0.0}), 0);
  // The line along x through (0, 0) runs through vertices and edges of both.
  EXPECT_EQ(winding.at({3.0, 0.0, 0.0}), 0);
  const double ball = enclosed_volume(tests::make_sphere({0, 0, 0}, 1.0, 4));
  const double lens = 2.0 * 4.0 / 3.0 * pi - two_balls(1.0, 1.0);
  EXPECT_NEAR(detail::wound_volume(both, 0.02, 1), 2.0 * ball - lens, 0.03);
  EXPECT_NEAR(detail::wound_volume(both, 0.02, 2), lens, 0.03);
}

TEST(UniteParts, TwoBalls) {
  for (const double apart : {0.3, 1.0, 1.7}) {
    const RepairedSurface repaired = repair_surface(detail::joined(
        {tests::make_sphere({0, 0, 0}, 1.0, 4), tests::make_sphere({apart, 0.01, 0.02}, 1.0, 4)}));
    expect_sound(repaired, two_balls(1.0, apart), 0.015);
    EXPECT_THAT(texts(repaired), Contains(HasSubstr("united")));
  }
}

TEST(UniteParts, TenClosedBranchesKeepTheirVolume) {
  double trunk = 0.0;
  const std::vector<TriangleMesh> parts = tree_of_branches(true, trunk);
  const RepairedSurface repaired = repair_surface(detail::joined(parts));
  // Of each branch at least what is beyond the trunk's radius, at most all of it.
  const double branch = enclosed_volume(parts[1]);
  EXPECT_GT(enclosed_volume(repaired.mesh), trunk + 10.0 * branch * (1.0 - 3.5 / 15.0));
  EXPECT_LT(enclosed_volume(repaired.mesh), trunk + 10.0 * branch);
  expect_sound(repaired, detail::volume_of_union(detail::joined(parts)), 0.02);
  const SurfaceRepair& united = repaired.repairs.back();
  EXPECT_EQ(united.count, 10);
  EXPECT_THAT(to_text(united), HasSubstr("united"));
}

TEST(UniteParts, OpenBranchesStayOpenAtTheirFreeEnds) {
  double trunk = 0.0;
  const RepairedSurface repaired = repair_surface(detail::joined(tree_of_branches(false, trunk)));
  EXPECT_EQ(surface_topology(repaired.mesh).component_count, 1);
  EXPECT_EQ(count_self_intersections(repaired.mesh), 0);
  const std::vector<SurfaceRim> rims = surface_rims(repaired.mesh);
  ASSERT_EQ(rims.size(), 12U);  // both ends of the trunk, one of each branch
  for (const SurfaceRim& rim : rims)
    EXPECT_TRUE(std::abs(rim.diameter_mm - 4.0) < 0.2 || std::abs(rim.diameter_mm - 1.8) < 0.1)
        << rim.diameter_mm;
}

TEST(UniteParts, InsideOutAndSelfCrossingPartsCountAsWell) {
  double trunk = 0.0;
  std::vector<TriangleMesh> parts = tree_of_branches(true, trunk);
  const double volume = detail::volume_of_union(detail::joined(parts));
  for (const std::size_t i : {0U, 3U, 7U})
    for (Triangle& t : parts[i].triangles) std::swap(t[0], t[1]);
  expect_sound(repair_surface(detail::joined(parts)), volume, 0.02);
  // A vertex of one branch is pulled through its far wall: no exact union of that.
  Vec3& p = parts[5].vertices[parts[5].vertices.size() / 2];
  const Vec3 middle = 0.5 * (parts[5].vertices[0] + parts[5].vertices[12]);
  const Vec3 axis = normalized(parts[5].vertices[24] - parts[5].vertices[0]);
  const Vec3 out = p - middle - dot(p - middle, axis) * axis;
  p -= 2.3 * out;
  expect_sound(repair_surface(detail::joined(parts)), volume, 0.03);
}

TEST(UniteParts, ATrunkThatCrossesItselfKeepsItsBranches) {
  double trunk = 0.0;
  std::vector<TriangleMesh> parts = tree_of_branches(true, trunk);
  const double volume = detail::volume_of_union(detail::joined(parts));
  Vec3& p = parts[0].vertices[parts[0].vertices.size() / 2];
  p = {-1.4 * p.x, -1.4 * p.y, p.z};  // a spike across the lumen and out on the other side
  const RepairedSurface repaired = repair_surface(detail::joined(parts));
  expect_sound(repaired, volume, 0.03);
  EXPECT_LT(repaired.mesh.triangles.size(), 40000U);  // the parts' own, not a contour's
}

/// A tube of 1 mm radius along z with a throat in whose wall, on one side, the rings do not follow
/// each other: it runs to and fro, and crosses itself.
TriangleMesh tube_with_folded_throat() {
  constexpr int kAround = 24;
  struct Ring {
    double z, r, z_folded, r_folded;
  };
  std::vector<Ring> rings;
  for (double z = -20.0; z < -0.9; z += 0.4) rings.push_back({z, 1.0, z, 1.0});
  rings.insert(rings.end(), {{-0.3, 0.5, -0.1, 0.5},
                             {-0.1, 0.4, 0.25, 0.36},
                             {0.1, 0.4, -0.25, 0.42},
                             {0.3, 0.5, 0.1, 0.5}});
  for (double z = 0.9; z < 20.1; z += 0.4) rings.push_back({z, 1.0, z, 1.0});
  TriangleMesh tube;
  for (const Ring& ring : rings)
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2.0 * pi * k / kAround;
      const double share = std::max(0.0, std::sin(angle));
      const double z = std::lerp(ring.z, ring.z_folded, share),
                   r = std::lerp(ring.r, ring.r_folded, share);
      tube.vertices.push_back({r * std::cos(angle), r * std::sin(angle), z});
    }
  for (int ring = 0; ring + 1 < int(rings.size()); ++ring)
    for (int k = 0; k < kAround; ++k) {
      const int a = ring * kAround + k, b = ring * kAround + (k + 1) % kAround;
      tube.triangles.push_back({a, b, b + kAround});
      tube.triangles.push_back({a, b + kAround, a + kAround});
    }
  return tube;
}

TEST(WoundParts, AreThoseThatHangTogether) {
  const TriangleMesh tube = tube_between({0, 0, 0}, {20, 3, 5}, 1.5, true, 48);
  const TriangleMesh aside = tube_between({0, 8, 0}, {10, 9, 2}, 1.0, true, 48);
  const double large = enclosed_volume(tube), small = enclosed_volume(aside);
  const std::vector<double> parts = detail::wound_parts(detail::joined({aside, tube}), 0.1);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_NEAR(parts[0] / large, 1.0, 0.01);
  EXPECT_NEAR(parts[1] / small, 1.0, 0.01);
  // Joined by a neck that only near lines see.
  const TriangleMesh neck = tube_between({5, 0, 1}, {5, 9, 1}, 0.1, true, 48);
  const TriangleMesh all = detail::joined({aside, tube, neck});
  const auto counted = [&](double distance) {
    const std::vector<double> seen = detail::wound_parts(all, distance);
    return std::count_if(seen.begin(), seen.end(), [](double part) { return part > 1.0; });
  };
  EXPECT_EQ(counted(0.05), 1);
  EXPECT_EQ(counted(0.5), 2);
}

TEST(UniteParts, AThroatWhoseWallCrossesItselfStaysOpen) {
  const TriangleMesh tube = detail::closed_copy(tube_with_folded_throat());
  ASSERT_GT(count_self_intersections(tube), 10);
  const RepairedSurface repaired = repair_surface(tube);
  expect_sound(repaired, detail::volume_of_union(tube), 0.02);
  // Nothing lies across its axis, nor near it.
  const TriangleMesh closed = detail::closed_copy(repaired.mesh);
  const detail::Winding winding(closed);
  for (const double aside : {-0.2, 0.01, 0.2})
    for (double z = -19.5; z < 19.5; z += 0.05) EXPECT_EQ(winding.at({0.01, aside, z}), 1) << z;
}

TEST(UniteParts, PartsThatTouchInAFaceAreOneVessel) {
  const RepairedSurface repaired = repair_surface(detail::joined(
      {tests::make_box({0, 0, 0}, {4, 1, 1}), tests::make_box({4, 0.2, 0.2}, {3, 0.6, 0.6})}));
  expect_sound(repaired, 4.0 + 3.0 * 0.36, 1e-9);
}

TEST(UniteParts, APartThatIsThereTwiceCountsOnce) {
  const TriangleMesh tube = tube_between({0, 0, 0}, {0, 0, 20}, 1.5, true, 32);
  const double volume = enclosed_volume(tube);
  expect_sound(repair_surface(detail::joined({tube, tube})), volume, 1e-9);
  TriangleMesh moved = tube;  // exported again, rounded another way
  for (Vec3& v : moved.vertices) v += Vec3{1e-3, 2e-3, -1e-3};
  expect_sound(repair_surface(detail::joined({tube, moved})), volume, 0.01);
}

TEST(UniteParts, TheInsideOfAWallIsTheLumen) {
  const TriangleMesh lumen = tube_between({0, 0, 1}, {0, 0, 29}, 1.5, true);
  TriangleMesh outer = tube_between({0, 0, 0}, {0, 0, 30}, 2.1, true);
  for (const bool inward : {false, true}) {
    TriangleMesh inner = lumen;
    if (inward)
      for (Triangle& t : inner.triangles) std::swap(t[0], t[1]);
    const RepairedSurface repaired = repair_surface(detail::joined({outer, inner}));
    expect_sound(repaired, enclosed_volume(lumen), 1e-9);
    EXPECT_THAT(texts(repaired), Contains(HasSubstr("outside of a wall left out")));
  }
  // A bubble in the lumen is none.
  const RepairedSurface bubble =
      repair_surface(detail::joined({lumen, tests::make_sphere({0, 0, 9}, 0.5, 2)}));
  expect_sound(bubble, enclosed_volume(lumen), 1e-9);
  EXPECT_THAT(texts(bubble), Contains(HasSubstr("inside the lumen left out")));
}

/// A helix of less pitch than its width, closed, and the volume of what it runs through.
TriangleMesh helix_through_itself(double& volume) {
  TriangleMesh mesh;
  constexpr int kSteps = 160, kSides = 20;
  for (int i = 0; i < kSteps; ++i)
    for (int k = 0; k < kSides; ++k) {
      const double a = 4.0 * pi * i / (kSteps - 1), b = 2.0 * pi * k / kSides;
      const double r = 6.0 + 1.5 * std::cos(b);
      mesh.vertices.push_back(
          {r * std::cos(a), r * std::sin(a), 2.4 * a / (2.0 * pi) + 1.5 * std::sin(b)});
    }
  for (int i = 0; i + 1 < kSteps; ++i)
    for (int k = 0; k < kSides; ++k) {
      const int p = i * kSides + k, q = i * kSides + (k + 1) % kSides;
      mesh.triangles.push_back({p, p + kSides, q});
      mesh.triangles.push_back({q, p + kSides, q + kSides});
    }
  // Two turns less what they share: a lens of two circles a pitch apart, carried around.
  const double r = 1.5, d = 2.4;
  const double lens =
      2.0 * r * r * std::acos(d / (2.0 * r)) - 0.5 * d * std::sqrt(4.0 * r * r - d * d);
  volume = 2.0 * pi * 6.0 * (2.0 * pi * r * r - lens);
  return detail::closed_copy(mesh);
}

TEST(UniteParts, ATubeThatRunsThroughItselfKeepsItsVolume) {
  double volume = 0.0;
  const TriangleMesh helix = helix_through_itself(volume);
  ASSERT_GT(count_self_intersections(helix), 100);
  expect_sound(repair_surface(helix), volume, 0.03);
}

TEST(UniteParts, OfWhatCrossesItselfAVesselApartIsKept) {
  double volume = 0.0;
  const TriangleMesh ball = tests::make_sphere({20, 0, 0}, 4.0, 4);
  const TriangleMesh both = detail::joined({helix_through_itself(volume), ball});
  const detail::Union united = detail::unite_parts({both});
  EXPECT_EQ(surface_topology(united.mesh).component_count, 2);
  EXPECT_EQ(count_self_intersections(united.mesh), 0);
  EXPECT_NEAR(enclosed_volume(united.mesh) / (volume + enclosed_volume(ball)), 1.0, 0.03);
}

/// Three tubes of 1 mm between the corners of a cube, which cross in its middle.
TriangleMesh three_diagonals(double side, double& volume) {
  const TriangleMesh tube = tube_between({0, 0, 0}, {side, side, side}, 0.5, true);
  TriangleMesh all = detail::joined({tube, tube_between({side, 0, 0}, {0, side, side}, 0.5, true),
                                     tube_between({0, side, 0}, {side, 0, side}, 0.5, true)});
  volume = 3.0 * enclosed_volume(tube);  // they share about 2 mm^3
  return all;
}

TEST(UniteParts, OfThinTubesOnLongDiagonalsTheVolumeIsKnown) {
  double volume = 0.0;
  const TriangleMesh tubes = three_diagonals(600.0, volume);
  EXPECT_NEAR(detail::volume_of_union(tubes) / volume, 1.0, 0.005);
}

TEST(UniteParts, AVertexFarAwayCostsNoLines) {
  TriangleMesh ball = tests::make_sphere({0, 0, 0}, 2.0, 4);
  const double volume = enclosed_volume(ball);
  ball.vertices.push_back({1e11, 1e11, 1e11});             // of no triangle
  EXPECT_LE(detail::volume_of_union(ball), 2.0 * volume);  // too far for its lines to tell
}

TEST(UniteParts, AContourGrowsWithTheWallAndNotWithTheBox) {
  double volume = 0.0;
  // A grid of the box with four steps across a tube would have over 2e8 nodes.
  const TriangleMesh tubes = three_diagonals(150.0, volume);
  const detail::Union united = detail::unite_parts({tubes});
  EXPECT_TRUE(surface_topology(united.mesh).is_closed());
  EXPECT_EQ(surface_topology(united.mesh).component_count, 1);
  EXPECT_NEAR(enclosed_volume(united.mesh) / volume, 1.0, 0.02);
}

TEST(UniteParts, AWallTooLargeForItsThinnestPartIsRefusedInOneLine) {
  // A part that crosses itself, so that there is no exact union, and a thread through it.
  const TriangleMesh all = detail::joined(
      {tests::make_sphere({0, 0, 0}, 400.0, 4), tests::make_sphere({300, 0, 0}, 400.0, 4)});
  detail::Union united =
      detail::unite_parts({all, tube_between({0, 0, 600}, {1, 2, -600}, 0.5, true)});
  EXPECT_TRUE(united.mesh.triangles.empty());
  const double area = 4.0 * pi * 400.0 * 400.0;  // of one sphere, at four steps to a millimetre
  EXPECT_GT(united.too_many, 4.0 * 16.0 * area);
  EXPECT_LT(united.too_many, 2.0 * 8.0 * 20.0 * area);
}

}  // namespace
}  // namespace angio::meshing

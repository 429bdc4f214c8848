#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "air_mesh/build/surface_crossings.hpp"
#include "meshing/detail/widening.hpp"
#include "meshing/meshing.hpp"
#include "testing/meshing/analytic_vessels.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

// A throat of a fifth of the vessel's width, which a balloon opens to that.
constexpr double kOpenRadius = 1.5, kMiddle = 10.0, kHalfLength = 5.0, kSeverity = 0.8;
constexpr double kThroat = (1.0 - kSeverity) * kOpenRadius;

double radius_at(double z) {
  return test::stenosis(kOpenRadius, kMiddle, kHalfLength, kSeverity)(z);
}

const test::Vessel& vessel() {
  static const test::Vessel kVessel = test::make_tube(20.0, 0.15, radius_at);
  return kVessel;
}

const std::vector<WidenedStretch> kStretches{
    {0, kMiddle - kHalfLength, kMiddle + kHalfLength, 2.0 * kOpenRadius}};

const LumenMesh& plain() {
  static const LumenMesh kLumen = mesh_lumen(vessel().level_set, vessel().tree, {});
  return kLumen;
}
const LumenMesh& widened() {
  static const LumenMesh kLumen = mesh_lumen(vessel().level_set, vessel().tree, {}, {}, kStretches);
  return kLumen;
}

/// The lumen with every section as wide as the balloon.
TriangleMesh opened(TriangleMesh mesh) {
  for (Vec3& p : mesh.vertices) {
    const double share = kOpenRadius / radius_at(p.z);
    p.x *= share;
    p.y *= share;
  }
  return mesh;
}

bool is_in_throat(const Vec3& p) { return std::abs(p.z - kMiddle) < 0.12 * kHalfLength; }

/// How much longer the throat's edges are along the vessel than around it, root mean squares.
double length_along_over_around(const TriangleMesh& mesh) {
  double along = 0.0, around = 0.0;
  for (const auto& [a, b] : unique_edges(mesh)) {
    const Vec3 p = mesh.vertices[std::size_t(a)], q = mesh.vertices[std::size_t(b)];
    if (!is_in_throat(p) || !is_in_throat(q)) continue;
    along += (p.z - q.z) * (p.z - q.z);
    around += (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y);
  }
  return std::sqrt(along / around);
}

/// Of the edges in the throat, the sharpest [degrees].
double sharpest_bend(const TriangleMesh& mesh) {
  const auto neighbors = triangle_neighbors(mesh);
  double most = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int other : neighbors[t]) {
      if (other < 0 || !is_in_throat(mesh.vertices[std::size_t(mesh.triangles[t][0])])) continue;
      const Vec3 n = area_vector_doubled(mesh, mesh.triangles[t]),
                 m = area_vector_doubled(mesh, mesh.triangles[std::size_t(other)]);
      most = std::max(most, std::atan2(norm(cross(n, m)), dot(n, m)) * 180.0 / pi);
    }
  return most;
}

/// Edges of the polygon in which a plane across the vessel cuts its triangles, over two: a plane
/// through rows of triangles cuts two for each edge around.
double edges_around(const TriangleMesh& mesh, double z) {
  const auto is_cut = [&](const Triangle& t) {
    const auto is_above = [&](int v) { return mesh.vertices[std::size_t(v)].z > z; };
    return is_above(t[0]) != is_above(t[1]) || is_above(t[1]) != is_above(t[2]);
  };
  return 0.5 * double(std::count_if(mesh.triangles.begin(), mesh.triangles.end(), is_cut));
}

TEST(Widening, ShortensLengthsAlongTheVesselByTheRootOfTheShareOfWidths) {
  const detail::Widening widening(vessel().tree, kStretches);
  for (const double z : {8.0, 10.0, 13.0}) {
    const Vec3 w = widening.at(Vec3{radius_at(z), 0.0, z});
    EXPECT_NEAR(norm_squared(w), 1.0 - std::sqrt(radius_at(z) / kOpenRadius), 0.01) << z;
    EXPECT_NEAR(std::abs(normalized(w).z), 1.0, 1e-9) << z;
    const Vec3 edge = detail::shortened({0.3, 0.4, 1.0}, w);
    EXPECT_NEAR(edge.x, 0.3, 1e-9);
    EXPECT_NEAR(edge.y, 0.4, 1e-9);
    EXPECT_NEAR(edge.z, std::sqrt(radius_at(z) / kOpenRadius), 0.01);
  }
}

TEST(Widening, LeavesTwoFifthsOfALengthAtTheLeast) {
  const detail::Widening widening(vessel().tree, {{0, 5.0, 15.0, 100.0 * kThroat}});
  const Vec3 edge = detail::shortened({0.0, 0.0, 1.0}, widening.at(Vec3{kThroat, 0.0, kMiddle}));
  EXPECT_NEAR(edge.z, 0.4, 1e-6);
}

TEST(Widening, IsNoneWhereNothingIsWidenedNorFarOffTheLine) {
  const detail::Widening widening(vessel().tree, kStretches);
  for (const Vec3& p : {Vec3{1.5, 0, 2.0}, Vec3{1.5, 0, 17.0}, Vec3{3.0 * kThroat, 0, 10.0}})
    EXPECT_EQ(norm(widening.at(p)), 0.0) << p.x << " " << p.z;
  const detail::Widening thinner(vessel().tree, {{0, 5.0, 15.0, 1.9 * kThroat}});
  EXPECT_EQ(norm(thinner.at(Vec3{kThroat, 0, 10.0})), 0.0);  // the balloon does not reach it
  EXPECT_TRUE(detail::Widening(vessel().tree, {{7, 5.0, 15.0, 3.0}}).is_none());
}

// The root of the widening, about five, before, and its inverse afterwards. Remeshing leaves
// lengths from 4/5 to 4/3 of those wanted, and rows come to lie close rather than far.
TEST(Widening, LeavesTrianglesHalfWayBetweenThoseOfBothShapes) {
  double sum = 0.0;
  int count = 0;
  for (const Vec3& p : widened().open.vertices)
    if (is_in_throat(p)) {
      sum += radius_at(p.z);
      ++count;
    }
  const double half_way = std::sqrt(kOpenRadius / (sum / count));
  const double before = length_along_over_around(plain().open),
               now = length_along_over_around(widened().open);
  EXPECT_NEAR(before, 1.0, 0.2);
  EXPECT_NEAR(now / before / half_way, 0.85, 0.2) << before;
  EXPECT_NEAR(length_along_over_around(opened(widened().open)) * half_way / before, 0.85, 0.2);
}

// Rows of n vertices around at half an edge to each other, h apart, on a circle of R: their edges
// are bent by 2 atan(R (1 - cos(pi / n)) / h). With equilateral triangles of the throat's size that
// is 31 degrees when it is five times as wide, with these 14.
TEST(Widening, NoEdgeIsBentSharplyOnceTheThroatIsOpen) {
  EXPECT_GT(sharpest_bend(opened(plain().open)), 35.0);
  EXPECT_LT(sharpest_bend(opened(widened().open)), 30.0);
  EXPECT_LT(sharpest_bend(widened().open), 30.0);
}

TEST(Widening, KeepsTheEdgesAroundTheShapeAndTheVolume) {
  EXPECT_NEAR(edges_around(widened().open, kMiddle + 0.01), 16.0, 2.5);
  EXPECT_NEAR(widened().quality.volume_change_percent, 0.0, 0.3);
  EXPECT_LT(widened().quality.distance_max_mm, 0.05);
  EXPECT_EQ(widened().self_intersection_count, 0);
  EXPECT_TRUE(widened().watertight);
  double least = 1e9, plain_least = 1e9;
  for (const Vec3& p : widened().open.vertices) least = std::min(least, std::hypot(p.x, p.y));
  for (const Vec3& p : plain().open.vertices)
    plain_least = std::min(plain_least, std::hypot(p.x, p.y));
  EXPECT_NEAR(least / plain_least, 1.0, 0.02);
}

// An equilateral triangle that is stretched by 2.2 has at least 28 degrees, whichever way it lies;
// flow solvers and the layers want 20 of the lumen's triangles.
TEST(Widening, LeavesNoNeedles) { EXPECT_GT(widened().min_angle_degrees, 20.0); }

}  // namespace
}  // namespace angio::meshing

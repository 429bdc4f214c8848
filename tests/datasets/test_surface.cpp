#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/units.hpp"
#include "datasets/detail/anatomy.hpp"
#include "datasets/detail/lumen_surface.hpp"
#include "datasets/phantom.hpp"

namespace angio::datasets {
namespace {

class PhantomSurface : public testing::TestWithParam<const char*> {};

TEST_P(PhantomSurface, IsOneClosedManifoldOnTheWallThatDoesNotFold) {
  const PhantomOptions options = parse_phantom(GetParam());
  const TriangleMesh surface = make_phantom_surface(options).surface;
  const SurfaceTopology topology = surface_topology(surface);
  EXPECT_TRUE(topology.is_closed());
  EXPECT_EQ(topology.component_count, 1);
  EXPECT_EQ(topology.euler_number, 2);
  EXPECT_GT(enclosed_volume(surface), 0.0);

  const datasets::detail::Anatomy anatomy = datasets::detail::make_anatomy(options);
  double farthest = 0.0, least_agreement = 1.0;
  for (const Vec3& vertex : surface.vertices)
    farthest = std::max(farthest, std::abs(anatomy.shape.signed_distance(vertex)));
  for (const Triangle& triangle : surface.triangles) {
    Vec3 middle;
    for (int v : triangle) middle += surface.vertices[std::size_t(v)] / 3.0;
    const Vec3 outward = anatomy.shape.nearest_wall(middle).normal;
    least_agreement =
        std::min(least_agreement, dot(outward, normalized(area_vector_doubled(surface, triangle))));
  }
  EXPECT_LT(farthest, 1e-4);
  EXPECT_GT(least_agreement, 0.2);  // negative for a triangle that is turned over
}

INSTANTIATE_TEST_SUITE_P(Shapes, PhantomSurface,
                         testing::Values("straight", "unilateral,stenosis=60",
                                         "unilateral,stenosis=95", "bilateral,stenosis=75",
                                         "ytype,stenosis=0", "ytype,stenosis=70",
                                         "ytype,radius=1,length=30", "coronary",
                                         "tandem,stenosis=80", "helix", "torus,stenosis=0",
                                         "trifurcation", "aneurysm,stenosis=50", "concentric",
                                         "coronary,radius=1.5,stenosis=0"));

struct PaperCounts {
  const char* phantom;
  std::size_t triangles, vertices, ends;
};

class PaperSurface : public testing::TestWithParam<PaperCounts> {};

TEST_P(PaperSurface, HasTheCountsOfTable2OnTheExactWallAndDoesNotFold) {
  const PhantomOptions options = parse_phantom(GetParam().phantom);
  const TriangleMesh surface = make_paper_surface(options);
  EXPECT_EQ(surface.triangles.size(), GetParam().triangles);
  EXPECT_EQ(surface.vertices.size(), GetParam().vertices);
  const SurfaceTopology topology = surface_topology(surface);
  EXPECT_EQ(topology.nonmanifold_edge_count, 0);
  EXPECT_EQ(topology.component_count, 1);
  EXPECT_EQ(topology.euler_number, 2 - int(GetParam().ends));
  EXPECT_EQ(boundary_loops(surface).size(), GetParam().ends);

  const datasets::detail::Anatomy anatomy = datasets::detail::make_anatomy(options);
  double least_agreement = 1.0, least_angle_sine = 1.0;
  for (const Vec3& vertex : surface.vertices)
    EXPECT_LT(std::abs(anatomy.shape.signed_distance(
                  vertex, datasets::detail::LumenShape::Ends::continued)),
              1e-4);
  for (const Triangle& t : surface.triangles) {
    Vec3 middle;
    for (const int v : t) middle += surface.vertices[std::size_t(v)] / 3.0;
    const Vec3 doubled = area_vector_doubled(surface, t);
    const Vec3 outward =
        anatomy.shape.nearest_wall(middle, datasets::detail::LumenShape::Ends::continued).normal;
    least_agreement = std::min(least_agreement, dot(outward, normalized(doubled)));
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3& x = surface.vertices[std::size_t(t[c])];
      const double a = distance(x, surface.vertices[std::size_t(t[(c + 1) % 3])]);
      const double b = distance(x, surface.vertices[std::size_t(t[(c + 2) % 3])]);
      least_angle_sine = std::min(least_angle_sine, norm(doubled) / (a * b));
    }
  }
  EXPECT_GT(least_agreement, 0.5);
  EXPECT_GT(least_angle_sine, std::sin(5.0 * units::kPi / 180.0));
}

INSTANTIATE_TEST_SUITE_P(
    Table2, PaperSurface,
    testing::Values(PaperCounts{"unilateral", 2400, 1220, 2},
                    PaperCounts{"unilateral,stenosis=85,radius=2", 2400, 1220, 2},
                    PaperCounts{"bilateral", 2400, 1220, 2}, PaperCounts{"ytype", 17600, 8859, 3},
                    PaperCounts{"ytype,stenosis=0,radius=1.4", 17600, 8859, 3},
                    PaperCounts{"ytype,stenosis=80", 17600, 8859, 3}));

TEST(TubeSurface, EnclosesThePrismOfItsRings) {
  const int n = 48;
  const double radius = 1.5, length = 40.0;
  const TriangleMesh surface =
      make_phantom_surface(parse_phantom("straight,radius=1.5,length=40")).surface;
  const double section = 0.5 * n * std::sin(2 * units::kPi / n) * radius * radius;
  EXPECT_NEAR(enclosed_volume(surface), section * length, 1e-6);
}

TEST(TreeSurface, TendsToTheCylinderWithFinerCells) {
  const datasets::detail::Anatomy tube =
      datasets::detail::make_anatomy(parse_phantom("straight,radius=1,length=10"));
  const double volume = units::kPi * 10.0;
  const double coarse = volume - enclosed_volume(datasets::detail::tree_surface(tube.shape, 0.3));
  const double fine = volume - enclosed_volume(datasets::detail::tree_surface(tube.shape, 0.15));
  EXPECT_GT(coarse, 0.0);
  EXPECT_GT(fine, 0.0);
  EXPECT_LT(fine, 0.4 * coarse);  // a quarter for second order
}

TEST(ClothSurface, IsThePapersSheet) {
  const Phantom cloth = make_phantom_surface(parse_phantom("cloth,length=20"));
  EXPECT_EQ(cloth.surface.vertices.size(), 51u * 51u);
  EXPECT_EQ(cloth.surface.triangles.size(), 5000u);
  EXPECT_NEAR(surface_area(cloth.surface), 400.0, 1e-9);
  EXPECT_EQ(surface_topology(cloth.surface).euler_number, 1);
  EXPECT_FALSE(cloth.truth.has_lesion);
}

}  // namespace
}  // namespace angio::datasets

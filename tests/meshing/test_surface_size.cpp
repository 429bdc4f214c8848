#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/surface_rims.hpp"
#include "meshing/detail/hollow.hpp"
#include "meshing/detail/pieces.hpp"
#include "meshing/repair_surface.hpp"
#include "meshing/surface_size.hpp"
#include "testing/shapes.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

TEST(SurfaceSize, IsThatOfAnAnalyticTube) {
  const TriangleMesh tube = tests::make_tube(2.0, 40.0, 81, 48);
  const SurfaceSize size = measure_surface(tube);
  EXPECT_NEAR(size.extent, 40.0, 1e-9);
  EXPECT_NEAR(size.volume, pi * 4.0 * 40.0, 0.01 * pi * 4.0 * 40.0);
  for (const double diameter : {size.thin, size.median, size.wide})
    EXPECT_NEAR(diameter, 4.0, 0.12);
  ASSERT_EQ(size.rims.size(), 2U);
  for (const SurfaceRim& rim : size.rims) EXPECT_NEAR(rim.diameter_mm, 4.0, 0.02);
}

TEST(SurfaceSize, SeesTheWidthAndNotTheLengthOfABallAndATorus) {
  const SurfaceSize ball = measure_surface(tests::make_sphere({1, 2, 3}, 5.0, 4));
  EXPECT_NEAR(ball.median, 10.0, 0.3);
  EXPECT_NEAR(ball.volume, 4.0 / 3.0 * pi * 125.0, 5.0);
  const SurfaceSize torus = measure_surface(tests::make_torus(10.0, 1.5, 96, 32));
  EXPECT_NEAR(torus.thin, 3.0, 0.12);
  EXPECT_NEAR(torus.wide, 3.0, 0.12);
  EXPECT_TRUE(torus.rims.empty());
}

TEST(SurfaceSize, ChangesWithTheUnit) {
  SurfaceSize size = measure_surface(tests::make_tube(0.2, 4.0, 41, 32));
  size.scale(10.0);
  EXPECT_NEAR(size.median, 4.0, 0.16);
  EXPECT_NEAR(size.extent, 40.0, 1e-9);
  EXPECT_NEAR(size.volume, pi * 4.0 * 40.0, 0.02 * pi * 4.0 * 40.0);
  EXPECT_NEAR(size.rims[0].diameter_mm, 4.0, 0.05);
}

/// The wall of a tube, inside and outside joined by rings at the ends.
TriangleMesh make_wall(double inner, double outer, double length) {
  const TriangleMesh outside = tests::make_tube(outer, length, 41, 32);
  TriangleMesh inside = tests::make_tube(inner, length, 41, 32);
  for (Triangle& t : inside.triangles) std::swap(t[0], t[1]);
  TriangleMesh wall = detail::joined({outside, inside});
  const int first = int(outside.vertices.size());
  for (int c = 0; c < 32; ++c)
    for (const int ring : {0, 40}) {
      int a = ring * 32 + c, b = ring * 32 + (c + 1) % 32;
      if (ring == 0) std::swap(a, b);
      wall.triangles.push_back({a, b, b + first});
      wall.triangles.push_back({a, b + first, a + first});
    }
  return wall;
}

TEST(SurfaceSize, TellsAWallFromALumen) {
  const TriangleMesh wall = make_wall(2.0, 2.5, 40.0);
  ASSERT_TRUE(surface_topology(wall).is_closed());
  EXPECT_GT(measure_surface(wall).hollow_share, 0.35);  // the inside is 44 % of the two
  EXPECT_LT(measure_surface(tests::make_tube(2.0, 40.0, 81, 48)).hollow_share, 0.01);
  EXPECT_LT(measure_surface(tests::make_torus(6.0, 2.0, 96, 32)).hollow_share, 0.1);
}

TEST(SurfaceSize, TheLumenInAWallIsOpenAtItsEndsOnly) {
  // A mound on the inner skin, whose slopes look along the lumen and out of its ends.
  TriangleMesh wall = make_wall(2.0, 2.5, 40.0);
  for (std::size_t v = wall.vertices.size() / 2; v < wall.vertices.size(); ++v) {
    Vec3& p = wall.vertices[v];
    const double away = distance(p, {2.0, 0.0, 20.0});
    p.x -= 2.5 * std::exp(-away * away / 4.0);
  }
  const TriangleMesh lumen = detail::hollow_of(wall);
  EXPECT_EQ(surface_rims(lumen).size(), 2U);
}

TEST(SurfaceSize, FindsTheLumenInAWall) {
  const double radius = 2.0, length = 40.0;
  const TriangleMesh lumen = lumen_of_wall(make_wall(radius, 2.5, length));
  ASSERT_FALSE(lumen.triangles.empty());
  for (const Vec3& v : lumen.vertices) EXPECT_NEAR(std::hypot(v.x, v.y), radius, 1e-9);
  // All of it but for less than a diameter at either end, from where one looks out.
  EXPECT_GT(surface_area(lumen), 2.0 * pi * radius * (length - 4.0 * radius));
  EXPECT_EQ(boundary_loops(lumen).size(), 2U);
  for (const Triangle& t : lumen.triangles) {  // normals leave the lumen
    const Vec3& v = lumen.vertices[std::size_t(t[0])];
    EXPECT_GT(dot(area_vector_doubled(lumen, t), Vec3{v.x, v.y, 0.0}), 0.0);
  }
}

TEST(SurfaceSize, OfAWallBesideAVesselBothLumensAreKept) {
  const double length = 40.0;
  TriangleMesh vessel = tests::make_tube(1.5, length, 41, 32);
  for (Vec3& v : vessel.vertices) v.x += 12.0;
  const RepairedSurface both = repair_surface(detail::joined({make_wall(2.0, 2.5, length), vessel}),
                                              {.keep_all_pieces = true});
  const SurfaceSize size = measure_surface(both.mesh);
  EXPECT_FALSE(is_wall(size));
  ASSERT_EQ(detail::connected_pieces(both.mesh).size(), 2U);
  for (const Vec3& v : both.mesh.vertices)
    EXPECT_LT(std::min(std::hypot(v.x, v.y), std::hypot(v.x - 12.0, v.y)), 2.01);  // no outer side
  EXPECT_GT(size.volume, pi * (1.5 * 1.5 * length + 4.0 * (length - 8.0)) * 0.98);
}

SurfaceSize of_sizes(double wide, double median, double extent) {
  SurfaceSize size;
  size.wide = wide;
  size.median = median;
  size.extent = extent;
  return size;
}

/// A vessel bed by its widest and median diameter and its length [mm]: ranges of adults.
struct Bed {
  const char* name;
  double wide[2], median[2], extent[2];
};
// Left main to aneurysm of the sinus; carotid bifurcation with bulb; circle of Willis with an
// aneurysm, and beyond it; thoracic and abdominal aorta with aneurysms; femoral artery.
constexpr Bed kBeds[] = {{"coronary tree", {3.0, 6.0}, {1.6, 3.0}, {45.0, 150.0}},
                         {"carotid bifurcation", {6.0, 11.0}, {3.5, 6.0}, {45.0, 250.0}},
                         {"cerebral arteries", {2.6, 12.0}, {1.4, 4.0}, {25.0, 130.0}},
                         {"distal cerebral arteries", {1.7, 2.5}, {1.0, 2.0}, {15.0, 60.0}},
                         {"thoracic aorta", {22.0, 55.0}, {18.0, 35.0}, {120.0, 350.0}},
                         {"aorta with iliac arteries", {16.0, 60.0}, {8.0, 25.0}, {180.0, 500.0}},
                         {"femoral artery", {5.0, 10.0}, {4.0, 8.0}, {80.0, 450.0}}};

TEST(UnitGuess, IsRightOrNamesTheRightOneForVesselsOfKnownBeds) {
  std::mt19937 random(7);
  const auto draw = [&](const double(&range)[2]) {
    return range[0] + (range[1] - range[0]) * double(random() % 100000) / 1e5;
  };
  for (const Bed& bed : kBeds)
    for (const LengthUnit truth : {LengthUnit::mm, LengthUnit::cm, LengthUnit::m})
      for (int i = 0; i < 400; ++i) {
        SurfaceSize size = of_sizes(draw(bed.wide), draw(bed.median), draw(bed.extent));
        size.median = std::min(size.median, size.wide);
        const bool is_usual = size.wide >= 2.5;
        size.scale(1.0 / kMillimetresOf[int(truth)]);
        const UnitGuess guess = guess_unit(size);
        // What is as wide as vessels usually are and in mm is never scaled; metres are always
        // known.
        if ((truth == LengthUnit::mm && is_usual) || truth == LengthUnit::m) {
          EXPECT_EQ(guess.unit, truth) << bed.name << " " << size_in_words(size, truth);
        }
        if (guess.unit != truth) {
          EXPECT_THAT(guess.others, testing::Contains(truth))
              << bed.name << " " << size_in_words(size, truth);
        }
      }
}

TEST(UnitGuess, LooksAtWhereTheSurfaceLies) {
  // 2.4 mm wide, so that it might be an aorta in cm; but that would lie outside of any scanner.
  SurfaceSize size = of_sizes(2.4, 1.6, 20.7);
  EXPECT_EQ(guess_unit(size).unit, LengthUnit::cm);
  size.low = {35.0, 31.0, 27.0};
  size.high = {55.7, 41.0, 40.0};
  EXPECT_EQ(guess_unit(size).unit, LengthUnit::mm);
  EXPECT_TRUE(guess_unit(size).others.empty());
}

TEST(UnitGuess, IgnoresThePlaceWhereTheSizeAllowsOneUnitOnly) {
  // A coronary tree with its aortic root, in cm, but moved to where no scanner has put it.
  SurfaceSize size = of_sizes(1.86, 0.24, 12.6);
  size.low = {69.8, 99.0, 108.2};
  size.high = {78.6, 111.6, 117.7};
  EXPECT_TRUE(guess_unit(size).is_vessel);
  EXPECT_EQ(guess_unit(size).unit, LengthUnit::cm);
  EXPECT_FALSE(is_possible(size, LengthUnit::mm));
}

TEST(UnitGuess, KnowsWhatNoScannerShows) {
  // A coronary tree in cm: 0.4 wide, 0.2 in the median, 10 long.
  const UnitGuess coronary = guess_unit(of_sizes(0.4, 0.2, 10.0));
  EXPECT_EQ(coronary.unit, LengthUnit::cm);
  EXPECT_TRUE(coronary.others.empty());
  // An aorta with its iliac arteries in cm would be a short piece of a small coronary in mm.
  const UnitGuess aorta = guess_unit(of_sizes(2.0, 1.1, 26.0));
  EXPECT_EQ(aorta.unit, LengthUnit::cm);
  EXPECT_THAT(aorta.others, testing::ElementsAre(LengthUnit::mm));
  // A cerebral artery in mm has the numbers of an aorta in cm.
  const UnitGuess artery = guess_unit(of_sizes(3.4, 3.0, 16.0));
  EXPECT_EQ(artery.unit, LengthUnit::mm);
  EXPECT_THAT(artery.others, testing::ElementsAre(LengthUnit::cm));
  // So does a thin one, but an aorta is not that long.
  const UnitGuess thin = guess_unit(of_sizes(1.37, 1.16, 84.7));
  EXPECT_EQ(thin.unit, LengthUnit::mm);
  EXPECT_THAT(thin.others, testing::ElementsAre(LengthUnit::cm));
  // What is a vessel in no unit is left alone, without a claim.
  const UnitGuess none = guess_unit(of_sizes(3.0, 2.0, 100000.0));
  EXPECT_EQ(none.unit, LengthUnit::mm);
  EXPECT_FALSE(none.is_vessel);
}

}  // namespace
}  // namespace angio::meshing

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"
#include "datasets/detail/anatomy.hpp"
#include "datasets/detail/lumen_surface.hpp"
#include "datasets/detail/scan.hpp"
#include "datasets/phantom.hpp"

namespace angio::datasets {
namespace {

namespace parts = angio::datasets::detail;

TEST(FractionBelowPlane, MatchesClosedForms) {
  EXPECT_NEAR(parts::fraction_below_plane({0, 0, 1}, 0.0), 0.5, 1e-6);
  EXPECT_NEAR(parts::fraction_below_plane({1, 0, 0}, 0.25), 0.25, 1e-4);
  EXPECT_NEAR(parts::fraction_below_plane({0, -1, 0}, -0.5), 1.0, 1e-4);
  EXPECT_EQ(parts::fraction_below_plane({0, 0, 1}, 0.6), 0.0);
  EXPECT_EQ(parts::fraction_below_plane({0, 0, 1}, -0.6), 1.0);
  // A corner cut off at a third of the diagonal: a tetrahedron with legs of one edge.
  const double s = 1.0 / std::sqrt(3.0);
  EXPECT_NEAR(parts::fraction_below_plane({s, s, s}, 0.5 * s), 1.0 / 6.0, 1e-9);
}

TEST(FractionBelowPlane, AndItsComplementFillTheCube) {
  for (int i = 0; i < 200; ++i) {
    const Vec3 n = normalized(Vec3{std::sin(1.0 * i), std::cos(2.3 * i), std::sin(0.7 * i + 1)});
    const double offset = 0.8 * std::sin(3.1 * i);
    EXPECT_NEAR(parts::fraction_below_plane(n, offset) + parts::fraction_below_plane(-n, -offset),
                1.0, 1e-8);
  }
}

TEST(LumenFraction, SumsToTheVolumeOfACylinder) {
  const double radius = 1.5, length = 20.0;
  const parts::Anatomy tube = parts::make_anatomy(parse_phantom("straight,radius=1.5,length=20"));
  for (double spacing : {0.25, 0.31, 0.7}) {
    const VolumeGeometry grid = parts::grid_around(tube.shape, {spacing, spacing, spacing}, 1.0);
    double sum = 0.0;
    for (float part : parts::lumen_fraction(tube.shape, grid, {}).values) sum += double(part);
    EXPECT_NEAR(sum * std::pow(spacing, 3) / (units::kPi * radius * radius * length), 1.0, 1e-3)
        << spacing;
  }
}

TEST(LumenFraction, SumsToTheVolumeInsideTheSurface) {
  for (const char* name : {"unilateral", "bilateral", "ytype", "coronary", "concentric", "tandem",
                           "helix", "torus", "trifurcation", "aneurysm"}) {
    const Phantom phantom = make_phantom_surface(parse_phantom(name));
    const parts::Anatomy anatomy = parts::make_anatomy(parse_phantom(name));
    const VolumeGeometry grid = parts::grid_around(anatomy.shape, {0.4, 0.4, 0.4}, 1.0);
    double sum = 0.0;
    for (float part : parts::lumen_fraction(anatomy.shape, grid, {}).values) sum += double(part);
    // The surface's flat triangles lie inside the wall: up to 0.3 % for 48 vertices around.
    EXPECT_NEAR(sum * std::pow(0.4, 3) / enclosed_volume(phantom.surface), 1.0, 5e-3) << name;
  }
}

TEST(LumenFraction, KeepsTheVolumeOnATurnedGrid) {
  PhantomOptions options = parse_phantom("helix,spacing=0.4,noise=0");
  const Phantom straight = make_phantom(options);
  options.oblique_degrees = 40.0;
  const Phantom turned = make_phantom(options);
  EXPECT_NEAR(norm(Vec3{turned.volume.geometry.direction(0, 0) - 1.0, 0.0, 0.0}), 0.0, 0.5);
  EXPECT_NE(turned.volume.geometry.direction(1, 0), 0.0);
  const auto lumen_sum = [](const Volume<float>& volume) {
    double sum = 0.0;
    for (float value : volume.values) sum += double(value) - kBackgroundIntensity;
    return sum;
  };
  EXPECT_NEAR(lumen_sum(turned.volume) / lumen_sum(straight.volume), 1.0, 2e-3);
  // What lies at a point of the patient does not depend on the grid.
  for (const Vec3& point : straight.truth.tree.paths[0].points)
    EXPECT_NEAR(interpolate(turned.volume, point), interpolate(straight.volume, point), 40.0);
}

TEST(LumenFraction, KeepsTheVolumeInThickSlices) {
  PhantomOptions options = parse_phantom("helix,spacing=0.4,noise=0");
  const Phantom cubes = make_phantom(options);
  options.slice_mm = 1.5;
  const Phantom slices = make_phantom(options);
  EXPECT_EQ(slices.volume.geometry.spacing.z, 1.5);
  const auto lumen_volume = [](const Volume<float>& volume) {
    double sum = 0.0;
    for (float value : volume.values) sum += double(value) - kBackgroundIntensity;
    const Vec3& h = volume.geometry.spacing;
    return sum * h.x * h.y * h.z;
  };
  EXPECT_NEAR(lumen_volume(slices.volume) / lumen_volume(cubes.volume), 1.0, 2e-3);
}

TEST(LumenFraction, IsTheSameWithAnyNumberOfThreads) {
  const parts::Anatomy anatomy = parts::make_anatomy(parse_phantom("ytype"));
  const VolumeGeometry grid = parts::grid_around(anatomy.shape, {0.5, 0.5, 0.5}, 1.0);
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const Volume<float> alone = parts::lumen_fraction(anatomy.shape, grid, {});
  omp_set_num_threads(4);
  const Volume<float> together = parts::lumen_fraction(anatomy.shape, grid, {});
  omp_set_num_threads(before);
  EXPECT_EQ(alone.values, together.values);
}

TEST(Blur, KeepsTheSumAndHasTheVarianceAskedFor) {
  VolumeGeometry grid;
  grid.size = {31, 31, 31};
  Volume<float> volume(grid);
  volume.at(15, 15, 15) = 1.0f;
  parts::blur(volume, {1.5, 1.5, 1.5});
  double sum = 0.0, second_moment = 0.0;
  for (int k = 0; k < 31; ++k)
    for (int j = 0; j < 31; ++j)
      for (int i = 0; i < 31; ++i) {
        sum += double(volume.at(i, j, k));
        second_moment += double(volume.at(i, j, k)) * (i - 15) * (i - 15);
      }
  EXPECT_NEAR(sum, 1.0, 1e-5);
  EXPECT_NEAR(second_moment, 1.5 * 1.5, 0.01 * 1.5 * 1.5);  // cut at 4 standard deviations
}

TEST(Noise, IsStandardNormal) {
  const int count = 200000;
  double sum = 0.0, squares = 0.0, within = 0.0;
  for (int i = 0; i < count; ++i) {
    const double x = parts::normal_number(7, std::uint64_t(i));
    sum += x;
    squares += x * x;
    within += std::abs(x) < 1.0 ? 1.0 : 0.0;
  }
  const double error = 4.0 / std::sqrt(double(count));  // four standard errors
  EXPECT_NEAR(sum / count, 0.0, error);
  EXPECT_NEAR(squares / count, 1.0, std::sqrt(2.0) * error);
  EXPECT_NEAR(within / count, 0.682689, 0.5 * error);
}

TEST(MakePhantom, HasTheIntensitiesAndTheNoiseAskedFor) {
  const Phantom phantom = make_phantom(parse_phantom("straight,length=15,noise=0.1"));
  const VolumeGeometry& grid = phantom.volume.geometry;
  double sum_in = 0.0, sum_out = 0.0, squares_out = 0.0;
  int count_in = 0, count_out = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 x = grid.lps_from_index({double(i), double(j), double(k)});
        const double value = double(phantom.volume.at(i, j, k)), r = std::hypot(x.x, x.y);
        if (r < 0.5 && std::abs(x.z) < 6.0) {
          sum_in += value;
          ++count_in;
        } else if (r > 3.0) {
          sum_out += value;
          squares_out += (value - kBackgroundIntensity) * (value - kBackgroundIntensity);
          ++count_out;
        }
      }
  const double sd = 0.1 * (kLumenIntensity - kBackgroundIntensity);
  EXPECT_NEAR(sum_in / count_in, kLumenIntensity, 5 * sd / std::sqrt(count_in));
  EXPECT_NEAR(sum_out / count_out, kBackgroundIntensity, 5 * sd / std::sqrt(count_out));
  EXPECT_NEAR(std::sqrt(squares_out / count_out), sd, 5 * sd / std::sqrt(2.0 * count_out));
}

TEST(MakePhantom, IsTheSameTwiceAndWithAnyNumberOfThreadsButNotWithAnotherSeed) {
  const PhantomOptions options = parse_phantom("ytype,spacing=0.6,seed=5,length=35");
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const Phantom alone = make_phantom(options);
  omp_set_num_threads(3);
  const Phantom together = make_phantom(options);
  omp_set_num_threads(before);
  EXPECT_EQ(alone.volume.values, together.volume.values);
  EXPECT_EQ(alone.surface.vertices, together.surface.vertices);
  EXPECT_EQ(alone.surface.triangles, together.surface.triangles);
  PhantomOptions other = options;
  other.seed = 6;
  EXPECT_NE(alone.volume.values, make_phantom(other).volume.values);
}

TEST(MakePhantom, SurroundsTheLumenWithBackground) {
  const Phantom phantom = make_phantom(parse_phantom("bilateral,spacing=0.5,noise=0"));
  const VolumeGeometry& grid = phantom.volume.geometry;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j) {
      EXPECT_NEAR(double(phantom.volume.at(0, j, k)), kBackgroundIntensity, 1e-3);
      EXPECT_NEAR(double(phantom.volume.at(grid.size[0] - 1, j, k)), kBackgroundIntensity, 1e-3);
    }
}

TEST(MakePhantom, RefusesToScanACloth) {
  EXPECT_THROW(make_phantom(parse_phantom("cloth")), InputError);
}

TEST(MakePhantom, RefusesMoreVoxelsThanAComputerHolds) {
  EXPECT_THROW(make_phantom(parse_phantom("coronary,length=200,spacing=0.05")), OptionError);
}

}  // namespace
}  // namespace angio::datasets

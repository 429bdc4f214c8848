#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "reconstruction/detail/few_views.hpp"
#include "reconstruction/detail/total_variation.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction::detail {
namespace {

using tests::Ball;
using tests::PicturesOfBalls;
using tests::turn;

struct Scene {
  std::vector<angiogram::ConeBeamFrame> frames;
  Orbit orbit;
  FrameStack stack;
  ChosenVoxels voxels;
  std::vector<int> all;
};

/// A grid whose columns have gaps, before frames that are tilted to it.
Scene make_scene() {
  Scene scene;
  scene.frames = turn(5, -80.0, 60.0, 40, 30, 7.0);
  scene.orbit = fit_orbit(scene.frames);
  const PlaneGrid plane = plane_grid(scene.frames, scene.orbit);
  scene.stack.u_count = plane.u_count;
  scene.stack.v_count = plane.v_count;
  for (std::size_t f = 0; f < scene.frames.size(); ++f) {
    scene.stack.places.push_back(place_on_plane(scene.frames[f], scene.orbit, f, plane));
    scene.all.push_back(int(f));
  }
  ColumnGrid& grid = scene.voxels.grid;
  grid.i_count = grid.j_count = grid.k_count = 12;
  grid.voxel = 0.7F;
  grid.first_x = grid.first_y = grid.first_z = -3.85F;
  grid.field_radius = 10.0F;
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 12; ++i)
      for (const auto& [first, count] : {std::pair{0, 4}, std::pair{6, 1 + (i + j) % 5}}) {
        scene.voxels.runs.push_back({i, j, first, count, scene.voxels.count});
        scene.voxels.count += std::size_t(count);
      }
  return scene;
}

std::vector<float> random_numbers(std::size_t count, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> numbers(-1.0F, 1.0F);
  std::vector<float> values(count);
  for (float& value : values) value = numbers(engine);
  return values;
}

double product(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += double(a[i]) * double(b[i]);
  return sum;
}

TEST(VoxelProjector, ProjectsBackByItsTranspose) {
  const Scene scene = make_scene();
  const std::vector<float> x = random_numbers(scene.voxels.count, 1),
                           y = random_numbers(scene.stack.per_frame() * scene.all.size(), 2);
  const double there = product(project(scene.voxels, x, scene.stack, scene.all), y);
  const double back = product(x, project_back(scene.voxels, y, scene.stack, scene.all));
  EXPECT_NEAR(there, back, 1e-5 * std::sqrt(product(x, x) * product(y, y)));
}

/// The line integrals of a voxel over the detector add up to its volume, as large as it is seen.
TEST(VoxelProjector, KeepsWhatIsInAVoxel) {
  const Scene scene = make_scene();
  const std::vector<float> one(scene.voxels.count, 1.0F);
  const double h = double(scene.voxels.grid.voxel);
  for (const int f : scene.all) {
    const std::vector<float> seen = project(scene.voxels, one, scene.stack, {f});
    const double sum = std::accumulate(seen.begin(), seen.end(), 0.0);
    double expected = 0.0;
    for (const VoxelRun& run : scene.voxels.runs) {
      const ColumnView view = view_column(scene.stack.places[std::size_t(f)],
                                          scene.voxels.grid.first_x + float(run.i) * float(h),
                                          scene.voxels.grid.first_y + float(run.j) * float(h));
      expected += run.count * h * h * h * double(view.v_per_mm) * double(view.v_per_mm);
    }
    EXPECT_NEAR(sum, expected, 2e-3 * expected) << f;
  }
}

double penalised(const std::vector<float>& x, const std::vector<float>& b, float strength,
                 const Neighbours& beside) {
  double sum = 0.0;
  for (std::size_t v = 0; v < x.size(); ++v) sum += 0.5 * double((x[v] - b[v]) * (x[v] - b[v]));
  return sum + double(strength) * total_variation(x, beside);
}

TEST(TotalVariation, IsLeastWhereItIsSmoothed) {
  const Scene scene = make_scene();
  const Neighbours beside = neighbours(scene.voxels);
  std::vector<float> b = random_numbers(scene.voxels.count, 3);
  for (float& value : b) value += 0.6F;
  constexpr float kStrength = 0.15F;
  std::vector<std::array<float, 3>> dual;
  const std::vector<float> x = smooth_by_total_variation(b, kStrength, beside, 400, dual);
  const double least = penalised(x, b, kStrength, beside);
  EXPECT_LT(least, 0.9 * penalised(b, b, kStrength, beside));
  for (unsigned seed = 4; seed < 24; ++seed) {
    const std::vector<float> way = random_numbers(x.size(), seed);
    std::vector<float> beside_it = x;
    for (std::size_t v = 0; v < x.size(); ++v) beside_it[v] = std::max(0.0F, x[v] + 0.01F * way[v]);
    EXPECT_GT(penalised(beside_it, b, kStrength, beside), least);
  }
  for (const float value : x) EXPECT_GE(value, 0.0F);
}

TEST(TotalVariation, OfNoStrengthOnlyTakesTheNegativeOut) {
  const Scene scene = make_scene();
  const std::vector<float> b = random_numbers(scene.voxels.count, 5);
  std::vector<std::array<float, 3>> dual;
  const auto x = smooth_by_total_variation(b, 0.0F, neighbours(scene.voxels), 10, dual);
  for (std::size_t v = 0; v < b.size(); ++v) EXPECT_EQ(x[v], std::max(0.0F, b[v]));
}

Reconstruction of_balls(const std::vector<angiogram::ConeBeamFrame>& frames,
                        const std::vector<Ball>& balls, Method method) {
  const PicturesOfBalls pictures(frames, balls);
  RotationalRun run;
  run.frames = frames;
  run.pictures = &pictures;
  ReconstructionOptions options;
  options.method = method;
  options.calibrate = false;
  options.air = 10000.0;
  return reconstruct_volume(run, options);
}

double sum_around(const Reconstruction& result, const Vec3& middle, double reach) {
  double sum = 0.0;
  const VolumeGeometry& g = result.volume.geometry;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i)
        if (norm(g.lps_from_index({double(i), double(j), double(k)}) - middle) <= reach)
          sum += double(result.volume.at(i, j, k));
  return sum * g.spacing.x * g.spacing.y * g.spacing.z;
}

const std::vector<Ball> kVessels = {{{3.0, -4.0, 2.0}, 1.5, 0.1}, {{-5.0, 3.0, -3.0}, 1.0, 0.1}};

TEST(FewViews, GiveBallsTheirAttenuationWithoutStreaks) {
  const Reconstruction result = of_balls(turn(19, -90.0, 90.0), kVessels, Method::few_views);
  EXPECT_EQ(result.quality.method, Method::few_views);
  EXPECT_TRUE(result.quality.has_converged);
  for (const Ball& ball : kVessels) {
    const double amount =
        ball.attenuation * 4.0 / 3.0 * M_PI * ball.radius * ball.radius * ball.radius;
    EXPECT_NEAR(sum_around(result, ball.middle, ball.radius + 1.2), amount, 0.06 * amount);
  }
  double elsewhere = 0.0;
  const VolumeGeometry& g = result.volume.geometry;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i) {
        const Vec3 place = g.lps_from_index({double(i), double(j), double(k)});
        EXPECT_GE(result.volume.at(i, j, k), 0.0F);
        if (norm(place - kVessels[0].middle) > 4.0 && norm(place - kVessels[1].middle) > 4.0)
          elsewhere = std::max(elsewhere, double(result.volume.at(i, j, k)));
      }
  EXPECT_LT(elsewhere, 0.01);
}

TEST(FewViews, TakeWideTissueOut) {
  std::vector<Ball> all = kVessels;
  all.push_back({{0, 0, 0}, 60.0, 0.02});
  const Reconstruction result = of_balls(turn(19, -90.0, 90.0), all, Method::few_views);
  for (const Ball& ball : kVessels) {
    const double amount =
        ball.attenuation * 4.0 / 3.0 * M_PI * ball.radius * ball.radius * ball.radius;
    EXPECT_NEAR(sum_around(result, ball.middle, ball.radius + 1.2), amount, 0.1 * amount);
  }
}

TEST(FewViews, AreForRunsOfFewFramesOnly) {
  const auto method_of = [](int frames, Method asked) {
    return of_balls(turn(frames, -90.0, 90.0), kVessels, asked).quality.method;
  };
  EXPECT_EQ(method_of(19, Method::automatic), Method::fdk);
  EXPECT_EQ(method_of(10, Method::automatic), Method::few_views);
  EXPECT_EQ(method_of(10, Method::fdk), Method::fdk);
}

}  // namespace
}  // namespace angio::reconstruction::detail

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "simulation/newton/wall_terms.hpp"
#include "simulation/wall.hpp"
#include "testing/simulation/thick_tubes.hpp"

namespace angio::simulation {
namespace {

using testing::kFibered;
using testing::mean_radius;
using testing::neo_hookean;
using testing::of_one_material;
using testing::round_tube;
using testing::tube_error;
using testing::TubeError;

// Gradient and Hessian of a whole solid [uN, uN/mm].
struct Sum {
  explicit Sum(std::size_t count)
      : gradient(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * count))),
        hessian(Eigen::MatrixXd::Zero(gradient.size(), gradient.size())) {}
  void add_gradient(int v, const Vec3& slope) {
    for (int i = 0; i < 3; ++i) gradient[3 * v + i] += slope[i];
  }
  void add_block(int i, int j, const Mat3& block) {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        hessian(3 * i + a, 3 * j + b) += block(a, b);
        if (i != j) hessian(3 * j + b, 3 * i + a) += block(a, b);
      }
  }
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};

Sum sum_of(const detail::SolidModel& model, const std::vector<Vec3>& x) {
  Sum sum(x.size());
  for (int p = 0; p < model.patch_count(); ++p)
    add_patch(model.view(x.data()), p, sum, [](Mat3(*)[6]) {});
  return sum;
}

TEST(SolidMesh, HasTheSlopesOfItsEnergy) {
  for (const WallRegionMaterial& m : {neo_hookean(20.0, 100.0), kFibered}) {
    const LayeredWall wall = make_tube_wall(round_tube(1.0, 1.5, 4, 1, 1.2));
    const detail::SolidModel model = detail::make_solid_model(wall, of_one_material(m));
    const detail::SolidTerm term(model);
    std::mt19937 random(3u);
    std::uniform_real_distribution<double> u(-0.03, 0.03);
    std::vector<Vec3> x = wall.vertices;
    for (Vec3& p : x) p += Vec3{u(random), u(random), u(random)};
    const Sum at = sum_of(model, x);
    EXPECT_LT((at.hessian - at.hessian.transpose()).norm(), 1e-12 * at.hessian.norm());
    const double h = 2e-5;
    const auto moved = [&](Eigen::Index k, double by) {
      std::vector<Vec3> y = x;
      y[static_cast<std::size_t>(k / 3)][static_cast<int>(k % 3)] += by;
      return y;
    };
    for (Eigen::Index k = 0; k < at.gradient.size(); ++k) {
      const auto e = [&](double by) { return term.value(moved(k, by)); };
      const auto g = [&](double by) { return sum_of(model, moved(k, by)).gradient; };
      EXPECT_NEAR((8.0 * (e(h) - e(-h)) - (e(2 * h) - e(-2 * h))) / (12.0 * h), at.gradient[k],
                  1e-6 * at.gradient.norm());
      const Eigen::VectorXd column = (8.0 * (g(h) - g(-h)) - (g(2 * h) - g(-2 * h))) / (12.0 * h);
      EXPECT_LT((column - at.hessian.col(k)).norm(), 1e-6 * at.hessian.norm());
    }
  }
}

TEST(SolidMesh, PassesThePatchTest) {
  // An even deformation of crooked wedges is a balance: no force on a vertex inside.
  TubeWall shape = round_tube(1.0, 1.8, 9, 4, 1.5);
  shape.inner_radius_mm = [](double a, double z) {
    return 1.0 + 0.1 * std::cos(3.0 * a + 5.0 * z);
  };
  const LayeredWall wall = make_tube_wall(shape);
  const detail::SolidModel model =
      detail::make_solid_model(wall, of_one_material(neo_hookean(20.0, 100.0)));
  Mat3 map;
  map.m[0][0] = 1.2, map.m[0][1] = 0.1, map.m[1][1] = 0.9, map.m[2][0] = -0.2, map.m[2][2] = 0.95;
  std::vector<Vec3> x = wall.vertices;
  for (Vec3& p : x) p = map * p;
  const Eigen::VectorXd f = sum_of(model, x).gradient;
  double most = 0.0, inside = 0.0;
  const std::size_t surface = wall.vertices.size() / 4;
  for (std::size_t v = 0; v < x.size(); ++v) {
    const double force = f.segment<3>(static_cast<Eigen::Index>(3 * v)).norm();
    most = std::max(most, force);
    if (wall.fixed[v] == 0 && v >= surface && v < 3 * surface) inside = std::max(inside, force);
  }
  EXPECT_LT(inside, 1e-10 * most);
}

TEST(SolidMesh, MovesFreelyOnlyAsARigidBody) {
  // The twist of a wedge strains nothing at its points; no mesh can have it everywhere.
  const LayeredWall wall = make_tube_wall(round_tube(1.0, 1.5, 8, 2, 1.2));
  const detail::SolidModel model =
      detail::make_solid_model(wall, of_one_material(neo_hookean(20.0, 100.0)));
  const Eigen::MatrixXd h = sum_of(model, wall.vertices).hessian;
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(h).eigenvalues();
  EXPECT_NEAR(values[5] / values[values.size() - 1], 0.0, 1e-12);
  EXPECT_GT(values[6] / values[values.size() - 1], 1e-5);
}

// By how much a narrowed tube's lumen grows under pressure, relative.
double lumen_growth(double bulk_ratio, int around, int along, int layers) {
  TubeWall shape = round_tube(1.2, 1.75, around, along, 5.0);
  shape.rim = 1;
  shape.inner_radius_mm = [](double a, double z) {
    return 1.2 - 0.5 * std::exp(-2.0 * (z - 2.5) * (z - 2.5)) * (1.0 + 0.4 * std::cos(a));
  };
  shape.layer_shares.assign(static_cast<std::size_t>(layers), 1.0);
  shape.layer_regions.assign(static_cast<std::size_t>(layers), WallRegion::media);
  const LayeredWall wall = make_tube_wall(shape);
  const WallSolution s =
      solve_wall(wall, of_one_material(neo_hookean(40.0, bulk_ratio)), unloaded_state(wall), 10.0);
  EXPECT_TRUE(s.converged);
  return enclosed_volume({s.state.vertices, wall.lumen_triangles}) /
             enclosed_volume({wall.vertices, wall.lumen_triangles}) -
         1.0;
}

struct ThinTube {
  double growth = 0.0;    ///< of the radius, relative
  double hoop_kpa = 0.0;  ///< mean circumferential stress
};

// A thin tube under pressure, far from its ends.
ThinTube thin_tube(double thickness_mm, double tissue_ratio, double pressure_kpa) {
  TubeWall shape = round_tube(1.5 - 0.5 * thickness_mm, 1.5 + 0.5 * thickness_mm, 24, 20, 10.0);
  shape.rim = 1;
  LayeredWall wall = make_tube_wall(shape);
  wall.tissue_ratio.assign(wall.wedges.size(), tissue_ratio);
  // The pressure on the lumen, p r_i, is what pulls the wall: the same of both.
  const WallSolution s =
      solve_wall(wall, of_one_material(neo_hookean(40.0, 200.0)), unloaded_state(wall),
                 pressure_kpa / (1.0 - thickness_mm / 3.0));
  EXPECT_TRUE(s.converged);
  const WallFields fields = wall_fields(wall, of_one_material(neo_hookean(40.0, 200.0)), s.state);
  ThinTube sum;
  int count = 0;
  for (std::size_t v = 0; v < wall.vertices.size(); ++v) {
    const Vec3 &before = wall.vertices[v], &now = s.state.vertices[v];
    if (std::abs(before.z - 5.0) > 2.0) continue;
    sum.growth += std::hypot(now.x, now.y) / std::hypot(before.x, before.y) - 1.0;
    sum.hoop_kpa += fields.vertices[v].circumferential_kpa;
    ++count;
  }
  return {sum.growth / count, sum.hoop_kpa / count};
}

TEST(SolidMesh, AThinWallThatStandsForMoreTissueIsAsStiffAsThatTissue) {
  // Laplace: p r = sigma h. A membrane's h may be in the wedge or in what it stands for.
  const ThinTube thick = thin_tube(0.04, 1.0, 0.1), thin = thin_tube(0.01, 4.0, 0.1);
  EXPECT_NEAR(thin.growth / thick.growth, 1.0, 0.02);
  EXPECT_NEAR(thin_tube(0.01, 1.0, 0.025).growth / thick.growth, 1.0, 0.02)
      << "a quarter, on a quarter";
  EXPECT_NEAR(thick.hoop_kpa, 0.1 * 1.5 * (1.0 + thick.growth) / 0.04 * (1.0 + thick.growth), 0.1);
  EXPECT_NEAR(thin.hoop_kpa / thick.hoop_kpa, 1.0, 0.02);
}

TEST(SolidMesh, DoesNotLockWhereItIsNearlyIncompressible) {
  // A coarse mesh is no stiffer against a finer one at K/G = 1000 (nu 0.4995) than at 5 (nu 0.41).
  const double soft = lumen_growth(5.0, 16, 7, 2) / lumen_growth(5.0, 24, 10, 3);
  const double stiff = lumen_growth(1000.0, 16, 7, 2) / lumen_growth(1000.0, 24, 10, 3);
  EXPECT_GT(soft, 0.95);
  EXPECT_GT(stiff, soft - 0.02);
}

TEST(ThickTube, NeoHookeanWidensAsTheClosedFormInThreeLayers) {
  for (const double inner : {1.1, 1.4}) {
    const TubeError e = tube_error(neo_hookean(20.0, 1000.0), inner, 48, {1.0, 1.0, 1.0});
    EXPECT_NEAR(e.inner, 0.0, 0.01);
    EXPECT_NEAR(e.outer, 0.0, 0.01);
  }
}

TEST(ThickTube, FiberReinforcedWidensAsTheIntegralAlongTheRadiusInThreeLayers) {
  WallRegionMaterial dispersed = kFibered;
  dispersed.fiber_share = 0.6;
  for (const WallRegionMaterial& m : {kFibered, dispersed})
    for (const double inner : {1.1, 1.3}) {
      const TubeError e = tube_error(m, inner, 36, {1.0, 1.0, 1.0});
      EXPECT_NEAR(e.inner, 0.0, 0.01);
      EXPECT_NEAR(e.outer, 0.0, 0.01);
    }
}

// Bends a tube along z to an arc.
void bend(double radius, LayeredWall& wall) {
  for (Vec3& p : wall.vertices) {
    const double angle = p.z / radius, out = radius + p.x;
    p = {out * std::cos(angle) - radius, p.y, out * std::sin(angle)};
  }
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    const Vec3 p = wall.vertices[static_cast<std::size_t>(wall.wedges[w][0])] + Vec3{radius, 0, 0};
    wall.axial[w] = normalized(Vec3{-p.z, 0, p.x});
  }
}

// A tube as seen under blood pressure: even, narrowed to one side, crooked, or bent.
LayeredWall seen_tube(const std::string& kind) {
  TubeWall shape = round_tube(1.2, 1.75, 20, 10, 4.0);
  shape.rim = kind == "even" ? char(8) : char(1);
  if (kind == "stenosed")
    shape.inner_radius_mm = [](double a, double z) {
      return 1.2 - 0.6 * std::exp(-2.0 * (z - 2.0) * (z - 2.0)) * (1.0 + 0.3 * std::cos(a));
    };
  if (kind == "crooked") {
    shape.inner_radius_mm = [](double a, double z) {
      return 1.2 + 0.12 * std::cos(3.0 * a + 2.0 * z) + 0.1 * std::sin(2.0 * z + a);
    };
    shape.outer_radius_mm = [](double a, double z) {
      return 1.75 + 0.1 * std::cos(2.0 * a - z) + 0.1 * std::sin(2.0 * z + a);
    };
  }
  LayeredWall wall = make_tube_wall(shape);
  if (kind == "stenosed")
    for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
      const double z = wall.vertices[static_cast<std::size_t>(wall.wedges[w][0])].z;
      if (wall.layer[w] == 0 && std::abs(z - 2.0) < 1.0) wall.region[w] = WallRegion::plaque;
    }
  if (kind == "bent") bend(5.0, wall);
  return wall;
}

class Prestress : public ::testing::TestWithParam<const char*> {};

TEST_P(Prestress, KeepsTheShapeThatWasSeenUnderBloodPressure) {
  const LayeredWall wall = seen_tube(GetParam());
  const WallOptions options;
  const WallSolution seen = prestress_wall(wall, options);
  EXPECT_TRUE(seen.converged);
  EXPECT_LT(seen.displacement_mm, 0.01);
  // It is a balance of its own, not an iteration cut short.
  WallState moved = seen.state;
  moved.vertices = wall.vertices;
  const WallSolution again = solve_wall(wall, options, moved, options.blood_pressure_kpa);
  EXPECT_TRUE(again.converged);
  EXPECT_LT(again.displacement_mm, 0.01);
  // Without the pressure the lumen narrows, with more it widens.
  const double inner = mean_radius(wall.lumen_triangles, wall.vertices);
  const WallSolution empty = solve_wall(wall, options, seen.state, 0.0);
  const WallSolution full = solve_wall(wall, options, seen.state, 20.0);
  EXPECT_TRUE(empty.converged && full.converged);
  EXPECT_LT(mean_radius(wall.lumen_triangles, empty.state.vertices), inner - 0.01);
  EXPECT_GT(mean_radius(wall.lumen_triangles, full.state.vertices), inner + 0.01);
}

INSTANTIATE_TEST_SUITE_P(Tubes, Prestress, ::testing::Values("even", "stenosed", "crooked", "bent"),
                         [](const auto& test) { return std::string(test.param); });

// Where meshing finds no room for layers there are none, and the columns around are held.
TEST(PrestressedTube, FindsItsBalanceAroundPlacesWithoutLayers) {
  LayeredWall wall = seen_tube("even");
  const std::size_t columns = wall.vertices.size() / 4, gone = wall.lumen_triangles.size() / 2;
  for (const int v : wall.lumen_triangles[gone])
    for (std::size_t level = 0; level < 4; ++level)
      wall.fixed[static_cast<std::size_t>(v) + level * columns] = 1;
  const std::size_t triangles = wall.lumen_triangles.size();
  const auto leave_out = [&](auto& values) {
    std::size_t i = 0;
    std::erase_if(values, [&](const auto&) { return i++ % triangles == gone; });
  };
  leave_out(wall.wedges);
  leave_out(wall.layer);
  leave_out(wall.region);
  leave_out(wall.axial);
  leave_out(wall.outer_triangles);
  const WallSolution seen = prestress_wall(wall, {});
  EXPECT_TRUE(seen.converged);
  EXPECT_LT(seen.displacement_mm, 0.01);
}

TEST(PrestressedTube, ReturnsToTheShapeFromWhichItWasLoaded) {
  LayeredWall wall = make_tube_wall(round_tube(1.2, 1.7, 24, 2, 0.5));
  const WallOptions options = of_one_material(kFibered);
  const WallSolution loaded = solve_wall(wall, options, unloaded_state(wall), 10.0);
  const std::vector<Vec3> unloaded = wall.vertices;
  wall.vertices = loaded.state.vertices;
  const WallSolution seen = prestress_wall(wall, options);
  const WallSolution empty = solve_wall(wall, options, seen.state, 0.0);
  ASSERT_TRUE(loaded.converged && seen.converged && empty.converged);
  EXPECT_GT(loaded.displacement_mm, 0.1);
  double most = 0.0;
  for (std::size_t v = 0; v < unloaded.size(); ++v)
    most = std::max(most, distance(empty.state.vertices[v], unloaded[v]));
  EXPECT_LT(most, 0.01);
}

TEST(PrestressedTube, CarriesThePressureByItsCircumferentialStress) {
  // Half a tube: the sum of the stress over the wall's section holds p times the lumen's diameter.
  const LayeredWall wall = make_tube_wall(round_tube(1.2, 1.75, 48, 2, 0.3));
  WallOptions options;
  options.foundation_kpa_per_mm = 1e-3;
  const WallSolution seen = prestress_wall(wall, options);
  ASSERT_TRUE(seen.converged);
  const WallFields fields = wall_fields(wall, options, seen.state);
  std::vector<double> sum(3, 0.0);
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    sum[static_cast<std::size_t>(wall.layer[w])] +=
        fields.wedges[w].circumferential_kpa / (static_cast<double>(wall.wedges.size()) / 3.0);
  const double total = 0.27 + 0.36 + 0.40;
  const double force = 0.55 * (0.27 * sum[0] + 0.36 * sum[1] + 0.40 * sum[2]) / total;
  EXPECT_NEAR(force, options.blood_pressure_kpa * 1.2, 0.01 * options.blood_pressure_kpa * 1.2);
}

TEST(PrestressedTube, IsNowhereAboveItsYieldStress) {
  const LayeredWall wall = seen_tube("stenosed");
  WallOptions options;
  options.materials[0].yield_kpa = options.materials[3].yield_kpa = 70.0;
  const WallSolution elastic = prestress_wall(wall, WallOptions{});
  const WallSolution seen = prestress_wall(wall, options);
  ASSERT_TRUE(elastic.converged && seen.converged);
  const auto most = [&](const WallSolution& s) {
    double stress = 0.0;
    for (const WallStress& w : wall_fields(wall, options, s.state).wedges)
      stress = std::max(stress, w.von_mises_kpa);
    return stress;
  };
  EXPECT_GT(most(elastic), 80.0);
  EXPECT_LT(most(seen), 1.05 * 70.0);  // at rest to 0.001 mm
}

TEST(WallFlow, WidensAYieldingTubeAsTheElasticPlasticSolution) {
  // Incompressible, plane strain, von Mises with k = yield / sqrt(3): plastic up to the radius c at
  // p = 2 k ln(c/a) + k (1 - c^2/b^2); the inner radius has then moved by k c^2 / (2 G a).
  // Source: Hill, "The Mathematical Theory of Plasticity" (1950), section V.2, for small strains.
  constexpr double kA = 1.0, kB = 1.6, kC = 1.3, kShear = 2e4, kK = 40.0;
  WallRegionMaterial m = neo_hookean(kShear, 500.0);
  m.yield_kpa = kK * std::sqrt(3.0);
  TubeWall shape = round_tube(kA, kB, 30, 1, 0.25);
  shape.layer_shares.assign(5, 1.0);
  shape.layer_regions.assign(5, WallRegion::media);
  const LayeredWall wall = make_tube_wall(shape);
  const double pressure = 2.0 * kK * std::log(kC / kA) + kK * (1.0 - kC * kC / (kB * kB));
  const WallSolution s = solve_wall(wall, of_one_material(m), unloaded_state(wall), pressure);
  EXPECT_TRUE(s.converged);
  const double moved = mean_radius(wall.lumen_triangles, s.state.vertices) - kA;
  EXPECT_NEAR(moved, kK * kC * kC / (2.0 * kShear * kA), 0.02 * moved);
}

TEST(WallFlow, LeavesAWidenedWallWider) {
  const LayeredWall wall = make_tube_wall(round_tube(1.2, 1.75, 16, 2, 0.5));
  WallOptions options;
  options.materials[0].yield_kpa = options.materials[1].yield_kpa = 60.0;
  options.materials[0].creep_per_s = options.materials[1].creep_per_s = 2.0;
  const WallSolution seen = prestress_wall(wall, options);
  WallSolution s = seen;
  for (int step = 0; step < 10; ++step) s = solve_wall(wall, options, s.state, 40.0, 0.1);
  ASSERT_TRUE(s.converged);
  s = solve_wall(wall, options, s.state, options.blood_pressure_kpa);
  ASSERT_TRUE(s.converged);
  EXPECT_GT(mean_radius(wall.lumen_triangles, s.state.vertices), 1.2 + 0.01);
  const WallFields fields = wall_fields(wall, options, s.state);
  double most = 0.0;
  for (const WallStress& v : fields.vertices) most = std::max(most, v.plastic_strain);
  EXPECT_GT(most, 0.01);
}

TEST(WallSolutions, DoNotDependOnTheRun) {
  const LayeredWall wall = seen_tube("stenosed");
  const WallState a = solve_wall(wall, {}, unloaded_state(wall), 3.0).state;
  const WallState b = solve_wall(wall, {}, unloaded_state(wall), 3.0).state;
  EXPECT_EQ(a.vertices, b.vertices);
}

}  // namespace
}  // namespace angio::simulation

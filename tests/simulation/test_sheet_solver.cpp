#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "simulation/newton/membrane_term.hpp"
#include "simulation/pbd/sheet_solver.hpp"
#include "testing/simulation/spheres.hpp"

namespace angio::simulation::detail {
namespace {

constexpr MooneyRivlin<double> kPolyurethane{1.031e6, 3.69e6};
constexpr double kThickness = 0.02, kDensity = 1.07e-3;

// An open sheet whose vertices have three to six triangles, and whose batches are not full.
TriangleMesh sheet(int cells = 9) {
  TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      mesh.vertices.push_back({0.5 * i + 0.1 * j, 0.45 * j, 0.02 * i * i});
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

std::vector<Vec3> shaken(const TriangleMesh& mesh, double by) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-by, by);
  std::vector<Vec3> x = mesh.vertices;
  for (Vec3& p : x) p += Vec3{shift(random), shift(random), shift(random)};
  return x;
}

SheetSolver solver_at(const TriangleMesh& mesh, const std::vector<Vec3>& x) {
  SheetSolver solver(mesh, kPolyurethane, kThickness, kDensity, {});
  for (std::size_t v = 0; v < x.size(); ++v) solver.set_position(int(v), x[v]);
  return solver;
}

double apart(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double worst = 0.0;
  for (std::size_t v = 0; v < a.size(); ++v) worst = std::max(worst, distance(a[v], b[v]));
  return worst;
}

TEST(SheetSolver, StretchedTriangleGoesBackToItsRestShape) {
  const TriangleMesh rest{{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  SheetSolver solver = solver_at(rest, {{0, 0, 0}, {3.1, 0.4, 0.6}, {0, 1, 0}});
  SheetStep still;
  still.dt = 0.0;
  still.sweeps = 100;
  solver.step(still);
  const std::vector<Vec3> x = solver.positions();
  for (std::size_t a = 0; a < 3; ++a)
    EXPECT_NEAR(distance(x[a], x[(a + 1) % 3]),
                distance(rest.vertices[a], rest.vertices[(a + 1) % 3]), 1e-5);
}

TEST(SheetSolver, RestIsWithoutStrain) {
  const TriangleMesh mesh = sheet();
  SheetSolver solver = solver_at(mesh, mesh.vertices);
  for (int i = 0; i < 10; ++i) solver.step({});
  const std::vector<Vec3> x = solver.positions();
  for (const auto& [a, b] : unique_edges(mesh)) {
    const auto i = std::size_t(a), j = std::size_t(b);
    EXPECT_NEAR(distance(x[i], x[j]) / distance(mesh.vertices[i], mesh.vertices[j]), 1.0, 1e-5);
  }
}

TEST(SheetSolver, FixedVertexStaysWhereItIsPut) {
  const TriangleMesh mesh = sheet();
  std::vector<char> fixed(mesh.vertices.size(), 0);
  fixed[0] = fixed[7] = 1;
  SheetSolver solver(mesh, kPolyurethane, kThickness, kDensity, fixed);
  const Vec3 pulled = mesh.vertices[7] + Vec3{0.0, -0.4, 0.1};
  solver.set_position(7, pulled);
  for (int i = 0; i < 5; ++i) solver.step({});
  EXPECT_LT(distance(solver.positions()[0], mesh.vertices[0]), 1e-6);
  EXPECT_LT(distance(solver.positions()[7], pulled), 1e-6);
  EXPECT_GT(distance(solver.positions()[8], mesh.vertices[8]), 0.01);
}

// The step's own law: m (x - x_inertial) / dt^2 = -dE/dx, found by Newton's method.
TEST(SheetSolver, StepIsImplicitEulers) {
  for (const TriangleMesh& mesh : {sheet(), testing::icosphere(1.0, 2)}) {
    const std::vector<Vec3> x = shaken(mesh, 0.05);
    SheetSolver solver = solver_at(mesh, x);
    SheetStep step;
    step.dt = 5e-6;
    step.sweeps = 300;
    solver.step(step);
    const MembraneTerm skin({kPolyurethane, {}, false}, mesh.triangles, mesh.vertices, kThickness);
    std::vector<double> mass = vertex_areas(mesh);
    for (double& m : mass) m *= kDensity * kThickness;
    const InertiaTerm inertia(mass, x, step.dt);
    std::vector<Vec3> expected = x;
    ASSERT_TRUE(
        minimize({&skin, &inertia}, std::vector<char>(x.size(), 0), expected, {}).converged);
    EXPECT_GT(apart(expected, x), 0.01);
    EXPECT_LT(apart(solver.positions(), expected), 1e-5);
  }
}

TEST(SheetSolver, WidthOfThePacksDoesNotChangeABit) {
  const TriangleMesh mesh = testing::icosphere(1.0, 3);
  const std::vector<Vec3> x = shaken(mesh, 0.05);
  SheetSolver wide = solver_at(mesh, x), narrow = solver_at(mesh, x);
  SheetStep step, step_narrow;
  step_narrow.lanes = 8;
  for (int i = 0; i < 5; ++i) {
    wide.step(step);
    narrow.step(step_narrow);
  }
  const std::vector<Vec3> a = wide.positions(), b = narrow.positions();
  EXPECT_GT(apart(a, x), 0.01);
  for (std::size_t v = 0; v < a.size(); ++v) EXPECT_EQ(a[v], b[v]);
}

TEST(SheetSolver, VertexWithoutTriangleStays) {
  TriangleMesh mesh = sheet(2);
  mesh.vertices.push_back({9.0, 9.0, 9.0});
  SheetSolver solver = solver_at(mesh, shaken(mesh, 0.02));
  const Vec3 before = solver.positions().back();
  solver.step({});
  EXPECT_EQ(solver.positions().back(), before);
}

}  // namespace
}  // namespace angio::simulation::detail

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "core/triangle_mesh.hpp"
#include "core/units.hpp"
#include "simulation/detail/membrane_term.hpp"
#include "simulation/detail/newton.hpp"

namespace angio::simulation::detail {
namespace {

constexpr MooneyRivlin<double> kPolyurethane{1.031e6, 3.69e6};
constexpr double kWall = 0.02;

// A sphere of 10 n^2 + 2 vertices: an icosahedron's faces cut in n^2, on a sphere. Two corners lie
// on the z axis, one in the half plane y = 0, x > 0.
TriangleMesh icosphere(double radius, int n) {
  std::vector<Vec3> corner{{0, 0, 1}};
  const double z = 1.0 / std::sqrt(5.0), r = 2.0 * z;
  for (int k = 0; k < 10; ++k) {
    const double angle = units::kPi / 5.0 * k;
    corner.push_back({r * std::cos(angle), k % 5 == 0 ? 0.0 : r * std::sin(angle), k % 2 ? -z : z});
  }
  corner.push_back({0, 0, -1});
  std::vector<Triangle> faces;
  const auto ring = [](int k) { return 1 + (k + 10) % 10; };
  for (int k = 0; k < 10; k += 2) {
    faces.push_back({0, ring(k), ring(k + 2)});
    faces.push_back({ring(k), ring(k + 1), ring(k + 2)});
    faces.push_back({ring(k + 1), ring(k + 3), ring(k + 2)});
    faces.push_back({11, ring(k + 3), ring(k + 1)});
  }
  TriangleMesh mesh;
  std::map<std::array<long long, 3>, int> index;
  const auto vertex = [&](const Vec3& flat) {
    const Vec3 p = normalized(flat);
    const std::array<long long, 3> key{std::llround(1e9 * p.x), std::llround(1e9 * p.y),
                                       std::llround(1e9 * p.z)};
    const auto [at, is_new] = index.try_emplace(key, int(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(radius * p);
    return at->second;
  };
  for (const auto& [a, b, c] : faces) {
    const auto at = [&](int i, int j) {
      return vertex((double(n - i - j) * corner[std::size_t(a)] +
                     double(i) * corner[std::size_t(b)] + double(j) * corner[std::size_t(c)]));
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
        if (i + j + 1 < n) mesh.triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  }
  return mesh;
}

std::vector<char> without_rigid_motion(const TriangleMesh& mesh) {
  std::vector<char> fixed(mesh.vertices.size(), 0);
  int turn = -1;
  for (std::size_t v = 0; v < fixed.size(); ++v) {
    const Vec3& p = mesh.vertices[v];
    if (std::hypot(p.x, p.y) < 1e-12)
      fixed[v] = p.z > 0 ? char(kFixedX | kFixedY | kFixedZ) : char(kFixedX | kFixedY);
    else if (turn < 0 && p.y == 0.0)
      turn = int(v);
  }
  fixed[std::size_t(turn)] = kFixedY;
  return fixed;
}

// Pressure of a sphere at stretch l: PHYSICS of the incompressible thin wall.
double sphere_pressure(double l, double radius) {
  return 4.0 * kWall / radius *
         (kPolyurethane.c1 * (1.0 / l - std::pow(l, -7)) +
          kPolyurethane.c2 * (l - std::pow(l, -5)));
}

struct Sphere {
  TriangleMesh mesh;
  MembraneTerm skin;
  std::vector<char> fixed;
  double volume;

  explicit Sphere(int n)
      : mesh(icosphere(1.5, n)),
        skin({kPolyurethane, {}, false}, mesh.triangles, mesh.vertices, kWall),
        fixed(without_rigid_motion(mesh)),
        volume(enclosed_volume(mesh)) {}

  NewtonResult solve(Enclosure::Control control, double target, std::vector<Vec3>& x,
                     double outside = 0.0) const {
    return minimize({&skin}, fixed, x, {}, {mesh.triangles, control, target, outside});
  }
};

// Stretch error of a sphere of 10 n^2 + 2 vertices on the radius, under pressures for stretches l.
std::vector<double> stretch_errors(int n, const std::vector<double>& stretches) {
  const Sphere sphere(n);
  std::vector<Vec3> x = sphere.mesh.vertices;
  std::vector<double> errors;
  for (const double l : stretches) {
    const auto result = sphere.solve(Enclosure::Control::pressure, sphere_pressure(l, 1.5), x);
    EXPECT_TRUE(result.converged) << l;
    errors.push_back(std::cbrt(result.volume / sphere.volume) / l - 1.0);
  }
  return errors;
}

TEST(Newton, ASphereFollowsItsClosedFormAndItsErrorFallsFourfoldWithRefinement) {
  const std::vector<double> l{1.05, 1.1, 1.2, 1.5, 2.0, 2.5, 3.0};
  const auto coarse = stretch_errors(7, l), fine = stretch_errors(14, l);  // 492, 1962 vertices
  for (std::size_t i = 0; i < l.size(); ++i) {
    EXPECT_LT(std::abs(coarse[i]), l[i] < 1.21 ? 0.0015 : 0.006) << l[i];
    EXPECT_LT(std::abs(fine[i]), l[i] < 1.21 ? 0.0015 : 0.006) << l[i];
    EXPECT_NEAR(coarse[i] / fine[i], 4.0, 0.1) << l[i];
  }
}

TEST(Newton, ConvergesQuadratically) {
  const Sphere sphere(7);
  std::vector<Vec3> x = sphere.mesh.vertices;
  const auto all = sphere.solve(Enclosure::Control::pressure, sphere_pressure(1.5, 1.5), x);
  EXPECT_TRUE(all.converged);
  EXPECT_LE(all.iterations, 12);
  EXPECT_LT(all.residual, 1e-9);
}

TEST(Newton, VolumeControlFindsThePressureOfThatVolume) {
  const Sphere sphere(4);
  for (const double l : {0.97, 1.1, 1.6}) {
    std::vector<Vec3> x = sphere.mesh.vertices, y = x;
    const double target = l * l * l * sphere.volume;
    const auto by_volume = sphere.solve(Enclosure::Control::volume, target, x);
    EXPECT_TRUE(by_volume.converged);
    EXPECT_NEAR(by_volume.volume, target, 1e-9 * target);
    y = x;
    const auto by_pressure = sphere.solve(Enclosure::Control::pressure, by_volume.pressure, y);
    EXPECT_NEAR(by_pressure.volume, target, 1e-6 * target);
  }
}

TEST(Newton, GasObeysItsLaw) {
  const Sphere sphere(4);
  const double outside = 101325.0 + 1e4;
  for (const double fill : {0.9, 1.0, 2.0, 10.0}) {
    std::vector<Vec3> x = sphere.mesh.vertices;
    const double gas = fill * outside * sphere.volume;
    const auto result = sphere.solve(Enclosure::Control::gas, gas, x, outside);
    EXPECT_TRUE(result.converged) << fill;
    EXPECT_NEAR((result.pressure + outside) * result.volume, gas, 1e-6 * gas);
    EXPECT_EQ(result.pressure > 0.0, fill > 1.0 + 1e-12);
  }
}

TEST(Newton, WorkOfThePressureIsTheChangeOfEnergyThereAndBack) {
  const Sphere sphere(4);
  std::vector<Vec3> x = sphere.mesh.vertices;
  double work = 0.0, volume = sphere.volume, pressure = 0.0, energy = 0.0;
  const int steps = 24;
  for (int k = 1; k <= 2 * steps; ++k) {
    const double l = 1.0 + 0.6 * (k <= steps ? k : 2 * steps - k) / steps;
    const auto r = sphere.solve(Enclosure::Control::volume, l * l * l * sphere.volume, x);
    ASSERT_TRUE(r.converged);
    work += 0.5 * (pressure + r.pressure) * (r.volume - volume);
    volume = r.volume;
    pressure = r.pressure;
    if (k == steps) {
      energy = r.energy;
      EXPECT_NEAR(work, energy, 0.01 * energy);
    }
    if (k == 2 * steps) {
      EXPECT_NEAR(work, 0.0, 1e-6 * energy);
      EXPECT_NEAR(r.energy, 0.0, 1e-9 * energy);
    }
  }
}

TEST(Newton, AnUnloadedBodyStaysWhereItIs) {
  const Sphere sphere(4);
  std::vector<Vec3> x = sphere.mesh.vertices;
  const auto result = sphere.solve(Enclosure::Control::pressure, 0.0, x);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.iterations, 0);
}

TEST(Newton, TheSameInputGivesTheSameBits) {
  const Sphere sphere(4);
  std::vector<Vec3> x = sphere.mesh.vertices, y = x;
  sphere.solve(Enclosure::Control::pressure, sphere_pressure(1.3, 1.5), x);
  sphere.solve(Enclosure::Control::pressure, sphere_pressure(1.3, 1.5), y);
  EXPECT_EQ(x, y);
}

// A spring between two points, k / 2 (|x0 - x1| - 1)^2: indefinite when pressed.
class Spring final : public EnergyTerm {
 public:
  [[nodiscard]] double value(const std::vector<Vec3>& x) const override {
    const double s = distance(x[0], x[1]) - 1.0;
    return 0.5 * kStiffness * s * s;
  }
  void add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const override {
    const Vec3 d = x[0] - x[1];
    const double length = norm(d), force = kStiffness * (length - 1.0);
    const Vec3 n = d / length;
    out.add_gradient(0, force * n);
    out.add_gradient(1, -force * n);
    const double across = clamp ? std::max(0.0, force / length) : force / length;
    const Mat3 block = (kStiffness - across) * outer(n, n) + across * Mat3::identity();
    out.add_block(0, 0, block);
    out.add_block(0, 1, -1.0 * block);
    out.add_block(1, 1, block);
  }
  static constexpr double kStiffness = 7.0;
};

TEST(Newton, FindsTheMinimumWhereTheHessianIsNotPositive) {
  const Spring spring;
  std::vector<Vec3> x{{0, 0, 0}, {0.3, 0.2, 0.0}};
  const auto result = minimize({&spring}, {kFixedAll, 0}, x, {});
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(distance(x[0], x[1]), 1.0, 1e-8);
  EXPECT_EQ(x[0], Vec3{});
}

TEST(Newton, InertiaMakesImplicitEulerSteps) {
  // A mass on a spring along x: (m / dt^2 + k) u = m / dt^2 (u + dt v), exactly.
  const Spring spring;
  const double m = 2.0, dt = 0.1, u = 0.05, v = 0.3, k = Spring::kStiffness;
  std::vector<Vec3> x{{0, 0, 0}, {1.0 + u, 0, 0}};
  const InertiaTerm inertia({0.0, m}, {x[0], x[1] + Vec3{dt * v, 0, 0}}, dt);
  const auto result = minimize({&spring, &inertia}, {kFixedAll, 0}, x, {});
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(x[1].x - 1.0, (u + dt * v) / (1.0 + k * dt * dt / m), 1e-9);
}

TEST(Newton, ReportsThatItDidNotConverge) {
  const Sphere sphere(4);
  std::vector<Vec3> x = sphere.mesh.vertices;
  const auto result = minimize({&sphere.skin}, sphere.fixed, x, {.most_iterations = 1},
                               {sphere.mesh.triangles, Enclosure::Control::pressure, 1e5});
  EXPECT_FALSE(result.converged);
  EXPECT_GT(result.residual, 1e-9);
}

}  // namespace
}  // namespace angio::simulation::detail

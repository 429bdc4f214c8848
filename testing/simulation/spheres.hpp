#pragma once

#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "core/units.hpp"
#include "simulation/newton/membrane_term.hpp"
#include "simulation/newton/newton.hpp"

/// Spheres of the seed paper's polyurethane.
namespace angio::simulation::testing {

using namespace detail;

inline constexpr MooneyRivlin<double> kPolyurethane{1.031e6, 3.69e6};
inline constexpr double kWall = 0.02;

// A sphere of 10 n^2 + 2 vertices: an icosahedron's faces cut in n^2, on a sphere. Two corners lie
// on the z axis, one in the half plane y = 0, x > 0.
inline TriangleMesh icosphere(double radius, int n) {
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
  for (const Triangle& face : faces) {
    const auto at = [&](int i, int j) {
      return vertex((double(n - i - j) * corner[std::size_t(face[0])] +
                     double(i) * corner[std::size_t(face[1])] +
                     double(j) * corner[std::size_t(face[2])]));
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
        if (i + j + 1 < n) mesh.triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  }
  return mesh;
}

inline std::vector<char> without_rigid_motion(const TriangleMesh& mesh) {
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
inline double sphere_pressure(double l, double radius) {
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

}  // namespace angio::simulation::testing

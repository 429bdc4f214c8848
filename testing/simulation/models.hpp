#pragma once

#include <cmath>
#include <vector>

#include "core/units.hpp"
#include "simulation/simulation.hpp"

/// Analytic models: a capsule balloon on the z axis in a stenosed tube.
namespace angio::simulation::testing {

/// A closed tube along z from -length/2 to length/2: rings, and a pole half a ring apart at each
/// end. Normals outward; the poles are the last two vertices. `radius(z)` is that of the section's
/// apothem-corrected polygon, so that the polygon has the area of the circle.
template <class Radius>
TriangleMesh closed_tube(double length, int ring_count, int around, const Radius& radius) {
  TriangleMesh mesh;
  const double step = length / (ring_count + 1);
  const double area_factor =
      std::sqrt(2.0 * units::kPi / (around * std::sin(2.0 * units::kPi / around)));
  for (int r = 0; r < ring_count; ++r) {
    const double z = -0.5 * length + (r + 1) * step;
    for (int k = 0; k < around; ++k) {
      const double angle = 2.0 * units::kPi * (k + 0.5 * (r % 2)) / around;
      const double size = area_factor * radius(z);
      mesh.vertices.push_back({size * std::cos(angle), size * std::sin(angle), z});
    }
  }
  const int low = int(mesh.vertices.size()), high = low + 1;
  mesh.vertices.push_back({0, 0, -0.5 * length});
  mesh.vertices.push_back({0, 0, 0.5 * length});
  for (int r = 0; r + 1 < ring_count; ++r)
    for (int k = 0; k < around; ++k) {
      const int n = (k + 1) % around;
      const int a = r * around + k, b = r * around + n, c = a + around, d = b + around;
      if (r % 2 == 0) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({b, d, c});
      } else {
        mesh.triangles.push_back({a, d, c});
        mesh.triangles.push_back({a, b, d});
      }
    }
  for (int k = 0; k < around; ++k) {
    const int n = (k + 1) % around, last = (ring_count - 1) * around;
    mesh.triangles.push_back({low, n, k});
    mesh.triangles.push_back({high, last + k, last + n});
  }
  return mesh;
}

/// An open tube along z, normals outward (leaving the lumen), in the same pattern; `shape(z,
/// angle)` is its radius.
template <class Shape>
TriangleMesh open_tube(double length, int ring_count, int around, const Shape& shape) {
  TriangleMesh mesh = closed_tube(length * (ring_count + 1) / (ring_count - 1), ring_count, around,
                                  [](double) { return 1.0; });
  mesh.vertices.resize(mesh.vertices.size() - 2);
  mesh.triangles.resize(mesh.triangles.size() - std::size_t(2 * around));
  for (Vec3& v : mesh.vertices) {
    const double angle = std::atan2(v.y, v.x), r = shape(v.z, angle);
    v.x = r * std::cos(angle);
    v.y = r * std::sin(angle);
  }
  return mesh;
}

struct StenosedTube {
  double radius = 1.5;
  double length = 24.0;
  double stenosis = 0.5;  ///< share of the diameter that is lost at z = 0
  double lesion_length = 8.0;
  double start_radius = 0.4;
  double nominal_radius = 1.5;
  double balloon_length = 12.0;
  bool eccentric = false;
  int balloon_rings = 26, balloon_around = 20;
  int wall_rings = 61, wall_around = 20;
};

/// A wrapped balloon (rest shape of the nominal radius, with conical ends) in a tube with a cosine
/// stenosis, concentric or on one side.
inline SimulationModel make_model(const StenosedTube& p) {
  SimulationModel model;
  model.balloon = closed_tube(p.balloon_length, p.balloon_rings, p.balloon_around,
                              [&](double) { return p.start_radius; });
  const double shoulder = std::min(1.0, 0.15 * p.balloon_length);
  TriangleMesh rest =
      closed_tube(p.balloon_length, p.balloon_rings, p.balloon_around, [&](double z) {
        const double to_end = 0.5 * p.balloon_length - std::abs(z);
        return p.start_radius +
               (p.nominal_radius - p.start_radius) * std::min(1.0, to_end / shoulder);
      });
  model.balloon_rest = rest.vertices;
  model.balloon_fixed.assign(model.balloon.vertices.size(), 0);
  model.balloon_fixed[model.balloon_fixed.size() - 1] = 1;
  model.balloon_fixed[model.balloon_fixed.size() - 2] = 1;
  model.guidewire = {{0, 0, -0.5 * p.balloon_length}, {0, 0, 0.5 * p.balloon_length}};
  model.wall = open_tube(p.length, p.wall_rings, p.wall_around, [&](double z, double angle) {
    if (std::abs(z) > 0.5 * p.lesion_length) return p.radius;
    const double depth =
        0.5 * (1.0 + std::cos(2.0 * units::kPi * z / p.lesion_length)) * p.stenosis * p.radius;
    return p.eccentric ? p.radius - 2.0 * depth * std::pow(std::cos(0.5 * angle), 4)
                       : p.radius - depth;
  });
  for (const Vec3& v : model.wall.vertices) {
    model.wall_fixed.push_back(std::abs(v.z) > 0.5 * p.length - 1e-6);
    model.wall_abscissa.push_back(v.z + 0.5 * p.length);
    model.wall_group.push_back(0);
  }
  model.reference_radius_mm = p.radius;
  model.measure_point = {0, 0, 0};
  model.measure_tangent = {0, 0, 1};
  return model;
}

}  // namespace angio::simulation::testing

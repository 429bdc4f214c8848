#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"
#include "datasets/detail/lumen_surface.hpp"
#include "datasets/detail/section.hpp"

namespace angio::datasets::detail {
namespace {

/// Two triangles for a quad whose corners turn counter-clockwise seen from outside.
void add_quad(TriangleMesh& mesh, int a, int b, int c, int d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

}  // namespace

TriangleMesh tube_wall(const LumenShape& shape, int vertices_per_ring, int ring_count) {
  ANGIO_EXPECT(shape.branches().size() == 1 && ring_count >= 2);
  const Branch& branch = shape.branches().front();
  const int n = vertices_per_ring;
  // Rings are plane and parallel, so triangles never cross.
  const Vec3 axis = branch.tangent(branch.first_sample);
  const Vec3 u = any_perpendicular(axis);
  const Vec3 v = cross(axis, u);

  TriangleMesh mesh;
  for (int ring = 0; ring < ring_count; ++ring) {
    const double exact =
        double(ring) / (ring_count - 1) * (branch.last_sample - branch.first_sample);
    const std::size_t below =
        std::size_t(std::min(branch.first_sample + int(exact), branch.last_sample - 1));
    const double t = branch.first_sample + exact - double(below);
    const Vec3 center = (1.0 - t) * branch.center[below] + t * branch.center[below + 1];
    for (int k = 0; k < n; ++k) {
      const double angle = 2.0 * units::kPi * k / n;
      const Vec3 direction = std::cos(angle) * u + std::sin(angle) * v;
      mesh.vertices.push_back(center + distance_to_wall(shape, center, direction) * direction);
    }
  }
  for (int k = 0; k < n; ++k)
    for (int ring = 0; ring + 1 < ring_count; ++ring) {
      const int next = (k + 1) % n;
      add_quad(mesh, ring * n + k, ring * n + next, (ring + 1) * n + next, (ring + 1) * n + k);
    }
  return mesh;
}

TriangleMesh tube_surface(const LumenShape& shape, int vertices_per_ring) {
  const Branch& branch = shape.branches().front();
  const int n = vertices_per_ring;
  const double length = (branch.last_sample - branch.first_sample) * branch.step_mm;
  const double edge = 2.0 * units::kPi * branch.healthy_mm.front() / n;
  const int ring_count = 1 + std::max(8, int(std::lround(length / edge)));
  TriangleMesh mesh = tube_wall(shape, n, ring_count);
  const int first_pole = int(mesh.vertices.size());
  mesh.vertices.push_back(branch.center[std::size_t(branch.first_sample)]);
  mesh.vertices.push_back(branch.center[std::size_t(branch.last_sample)]);
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    mesh.triangles.push_back({first_pole, next, k});
    const int last = (ring_count - 1) * n;
    mesh.triangles.push_back({first_pole + 1, last + k, last + next});
  }
  return mesh;
}

TriangleMesh cloth_surface(double side_mm) {
  constexpr int kSide = 51;
  TriangleMesh mesh;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i)
      mesh.vertices.push_back({side_mm * (double(i) / (kSide - 1) - 0.5),
                               side_mm * (double(j) / (kSide - 1) - 0.5), 0.0});
  for (int j = 0; j + 1 < kSide; ++j)
    for (int i = 0; i + 1 < kSide; ++i) {
      const int a = j * kSide + i;
      add_quad(mesh, a, a + 1, a + kSide + 1, a + kSide);
    }
  return mesh;
}

}  // namespace angio::datasets::detail

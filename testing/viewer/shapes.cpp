#include "testing/viewer/shapes.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace angio::viewer::test {

TriangleMesh make_cube(const Vec3& offset) {
  TriangleMesh mesh;
  for (int v = 0; v < 8; ++v)
    mesh.vertices.push_back(offset + Vec3{double(v & 1), double(v >> 1 & 1), double(v >> 2 & 1)});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

double TubeShape::radius_at(double z) const {
  const double u = (z - 0.5 * length_mm) / 3.0;
  return radius_mm * (1.0 - depth * std::exp(-u * u));
}

Vec3 TubeShape::center_at(double z) const {
  return {bend_mm * std::sin(units::kPi * z / length_mm), 0.0, z};
}

namespace {

/// Rings along z; triangles turn counter-clockwise seen from outside.
void add_rings(TriangleMesh& mesh, const std::vector<Vec3>& centers,
               const std::vector<double>& radii, int ring_vertex_count) {
  for (std::size_t r = 0; r < centers.size(); ++r)
    for (int v = 0; v < ring_vertex_count; ++v) {
      const double angle = 2.0 * units::kPi * v / ring_vertex_count;
      mesh.vertices.push_back(centers[r] + radii[r] * Vec3{std::cos(angle), std::sin(angle), 0.0});
    }
  for (int r = 0; r + 1 < int(centers.size()); ++r)
    for (int v = 0; v < ring_vertex_count; ++v) {
      const int next = (v + 1) % ring_vertex_count;
      const int a = r * ring_vertex_count;
      const int b = a + ring_vertex_count;
      mesh.triangles.push_back({a + v, a + next, b + v});
      mesh.triangles.push_back({a + next, b + next, b + v});
    }
}

}  // namespace

TriangleMesh make_tube(const TubeShape& shape) {
  std::vector<Vec3> centers;
  std::vector<double> radii;
  for (int r = 0; r < shape.ring_count; ++r) {
    const double z = shape.length_mm * r / (shape.ring_count - 1);
    centers.push_back(shape.center_at(z));
    radii.push_back(shape.radius_at(z));
  }
  TriangleMesh mesh;
  add_rings(mesh, centers, radii, shape.ring_vertex_count);
  return mesh;
}

TriangleMesh make_balloon(const TubeShape& shape, double z0, double z1, double radius_mm) {
  constexpr int kRings = 26;
  constexpr int kRingVertices = 20;
  std::vector<Vec3> centers;
  std::vector<double> radii;
  for (int r = 0; r < kRings; ++r) {
    const double u = double(r + 1) / (kRings + 1);
    const double taper = std::min(1.0, 4.0 * std::min(u, 1.0 - u));
    centers.push_back(shape.center_at(z0 + u * (z1 - z0)));
    radii.push_back(radius_mm * taper);
  }
  TriangleMesh mesh;
  add_rings(mesh, centers, radii, kRingVertices);
  const int first_pole = int(mesh.vertices.size());
  mesh.vertices.push_back(shape.center_at(z0));
  mesh.vertices.push_back(shape.center_at(z1));
  const int last_ring = (kRings - 1) * kRingVertices;
  for (int v = 0; v < kRingVertices; ++v) {
    const int next = (v + 1) % kRingVertices;
    mesh.triangles.push_back({first_pole, next, v});
    mesh.triangles.push_back({first_pole + 1, last_ring + v, last_ring + next});
  }
  return mesh;
}

CenterlinePath make_path(const TubeShape& shape) {
  CenterlinePath path;
  constexpr int kPoints = 121;
  for (int i = 0; i < kPoints; ++i) {
    const double z = shape.length_mm * i / (kPoints - 1);
    const double radius = shape.radius_at(z);
    path.points.push_back(shape.center_at(z));
    path.inscribed_radius.push_back(radius);
    path.equivalent_radius.push_back(radius);
    path.section_area.push_back(units::kPi * radius * radius);
  }
  path.abscissa = arc_length(path.points);
  path.tracts.push_back({0, kPoints - 1, 0, 0, false});
  return path;
}

TubeVolumes make_volumes(const TubeShape& shape) {
  VolumeGeometry grid;
  grid.spacing = {0.5, 0.5, 0.5};
  const double margin = 4.0;
  grid.origin = {-margin, -margin, -2.0};
  grid.size = {int((2 * margin + shape.bend_mm) / 0.5), int(2 * margin / 0.5),
               int((shape.length_mm + 4.0) / 0.5)};
  TubeVolumes result{Volume<float>(grid), Volume<float>(grid)};
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = grid.lps_from_index({double(i), double(j), double(k)});
        const Vec3 d = p - shape.center_at(p.z);
        const double distance = std::hypot(d.x, d.y) - shape.radius_at(p.z);
        result.level_set.at(i, j, k) = float(distance);
        result.volume.at(i, j, k) = float(40.0 + 260.0 / (1.0 + std::exp(6.0 * distance)));
      }
  return result;
}

}  // namespace angio::viewer::test

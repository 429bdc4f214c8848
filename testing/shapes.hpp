#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "core/units.hpp"

/// Analytic shapes for tests: surfaces whose volume, area and topology are known in closed form.
namespace angio::tests {

/// A closed box with one corner at `corner`, outward normals, 12 triangles.
inline TriangleMesh make_box(const Vec3& corner, const Vec3& size) {
  TriangleMesh mesh;
  for (int c = 0; c < 8; ++c)
    mesh.vertices.push_back(
        corner + Vec3{(c & 1) ? size.x : 0.0, (c & 2) ? size.y : 0.0, (c & 4) ? size.z : 0.0});
  constexpr std::array<std::array<int, 4>, 6> kFaces{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& f : kFaces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

/// An octahedron whose faces were split in four `level` times, all vertices on the sphere:
/// 8 * 4^level triangles, outward normals.
inline TriangleMesh make_sphere(const Vec3& centre, double radius, int level) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int l = 0; l < level; ++l) {
    std::map<std::pair<int, int>, int> midpoints;
    const auto midpoint = [&](int a, int b) {
      const auto [entry, is_new] =
          midpoints.try_emplace(std::minmax(a, b), int(mesh.vertices.size()));
      if (is_new)
        mesh.vertices.push_back(
            normalized(mesh.vertices[std::size_t(a)] + mesh.vertices[std::size_t(b)]));
      return entry->second;
    };
    std::vector<Triangle> split;
    for (const Triangle& t : mesh.triangles) {
      const int a = midpoint(t[0], t[1]), b = midpoint(t[1], t[2]), c = midpoint(t[2], t[0]);
      split.insert(split.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
    }
    mesh.triangles = std::move(split);
  }
  for (Vec3& v : mesh.vertices) v = centre + radius * v;
  return mesh;
}

/// The surface of unit cubes, a vertex for each corner of the grid.
inline TriangleMesh surface_of_cubes(const std::vector<std::array<int, 3>>& cubes) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> vertex_at;
  const auto vertex = [&](std::array<int, 3> at) {
    const auto [known, is_new] = vertex_at.try_emplace(at, int(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back({double(at[0]), double(at[1]), double(at[2])});
    return known->second;
  };
  for (const std::array<int, 3>& cube : cubes)
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int side : {0, 1}) {
        std::array<int, 3> beside = cube;
        beside[axis] += 2 * side - 1;
        if (std::find(cubes.begin(), cubes.end(), beside) != cubes.end()) continue;
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        std::array<int, 4> quad{};
        for (int k = 0; k < 4; ++k) {
          std::array<int, 3> at = cube;
          at[axis] += side;
          at[u] += k == 1 || k == 2 ? 1 : 0;
          at[v] += k >= 2 ? 1 : 0;
          quad[std::size_t(side == 1 ? k : 3 - k)] = vertex(at);
        }
        mesh.triangles.push_back({quad[0], quad[1], quad[2]});
        mesh.triangles.push_back({quad[0], quad[2], quad[3]});
      }
  return mesh;
}

/// An open tube along z from 0 to `length`: rings of `ring_vertex_count` vertices on the radius,
/// outward normals.
inline TriangleMesh make_tube(double radius, double length, int ring_count, int ring_vertex_count) {
  TriangleMesh mesh;
  for (int r = 0; r < ring_count; ++r)
    for (int c = 0; c < ring_vertex_count; ++c) {
      const double angle = 2.0 * units::kPi * c / ring_vertex_count;
      mesh.vertices.push_back(
          {radius * std::cos(angle), radius * std::sin(angle), length * r / (ring_count - 1)});
    }
  for (int r = 0; r + 1 < ring_count; ++r)
    for (int c = 0; c < ring_vertex_count; ++c) {
      const int a = r * ring_vertex_count + c;
      const int b = r * ring_vertex_count + (c + 1) % ring_vertex_count;
      mesh.triangles.push_back({a, b, b + ring_vertex_count});
      mesh.triangles.push_back({a, b + ring_vertex_count, a + ring_vertex_count});
    }
  return mesh;
}

/// A closed torus around z, outward normals.
inline TriangleMesh make_torus(double ring_radius, double tube_radius, int ring_count,
                               int ring_vertex_count) {
  TriangleMesh mesh;
  for (int r = 0; r < ring_count; ++r)
    for (int c = 0; c < ring_vertex_count; ++c) {
      const double u = 2.0 * units::kPi * r / ring_count;
      const double v = 2.0 * units::kPi * c / ring_vertex_count;
      const double w = ring_radius + tube_radius * std::cos(v);
      mesh.vertices.push_back({w * std::cos(u), w * std::sin(u), tube_radius * std::sin(v)});
    }
  const auto at = [&](int r, int c) {
    return (r % ring_count) * ring_vertex_count + c % ring_vertex_count;
  };
  for (int r = 0; r < ring_count; ++r)
    for (int c = 0; c < ring_vertex_count; ++c) {
      mesh.triangles.push_back({at(r, c), at(r + 1, c), at(r + 1, c + 1)});
      mesh.triangles.push_back({at(r, c), at(r + 1, c + 1), at(r, c + 1)});
    }
  return mesh;
}

}  // namespace angio::tests

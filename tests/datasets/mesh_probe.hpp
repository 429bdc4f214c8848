#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/triangle_mesh.hpp"

/// Measurements on a triangle mesh by definition, independent of how the mesh was made.
namespace angio::tests {

/// From a point to a triangle (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
inline Vec3 nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = dot(ab, p - b), d4 = dot(ac, p - b);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + (d1 / (d1 - d3)) * ab;
  const double d5 = dot(ab, p - c), d6 = dot(ac, p - c);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
  const double sum = va + vb + vc;
  return a + (vb / sum) * ab + (vc / sum) * ac;
}

inline double distance_to_mesh(const TriangleMesh& mesh, const Vec3& p) {
  double least = std::numeric_limits<double>::max();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 q =
        nearest_on_triangle(p, mesh.vertices[std::size_t(t[0])], mesh.vertices[std::size_t(t[1])],
                            mesh.vertices[std::size_t(t[2])]);
    least = std::min(least, distance(p, q));
  }
  return least;
}

/// The area of a closed surface's section with a plane, of what lies within `reach` of `center`:
/// half the sum of segment x position over the section's segments, each turned the same way.
inline double section_area(const TriangleMesh& mesh, const Vec3& center, const Vec3& normal,
                           double reach) {
  Vec3 sum;
  for (const Triangle& t : mesh.triangles) {
    std::vector<Vec3> ends;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3 a = mesh.vertices[std::size_t(t[c])] - center;
      const Vec3 b = mesh.vertices[std::size_t(t[(c + 1) % 3])] - center;
      const double h_a = dot(a, normal), h_b = dot(b, normal);
      if ((h_a < 0) != (h_b < 0)) ends.push_back(a + (h_a / (h_a - h_b)) * (b - a));
    }
    if (ends.size() != 2 || norm(ends[0]) > reach) continue;
    const Vec3 along = cross(normal, area_vector_doubled(mesh, t));
    const double sign = dot(ends[1] - ends[0], along) > 0 ? 1.0 : -1.0;
    sum += sign * cross(ends[0], ends[1]);
  }
  return 0.5 * dot(sum, normal);
}

}  // namespace angio::tests

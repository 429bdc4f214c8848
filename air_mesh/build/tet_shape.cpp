#include "air_mesh/build/tet_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace angio::air_mesh {
namespace {

std::array<Vec3, 4> outward_normals(const std::array<Vec3, 4>& x) {
  std::array<Vec3, 4> normals;
  for (std::size_t f = 0; f < 4; ++f) {
    const Vec3& a = x[std::size_t(kTetFaces[f][0])];
    normals[f] = cross(x[std::size_t(kTetFaces[f][1])] - a, x[std::size_t(kTetFaces[f][2])] - a);
  }
  return normals;
}

}  // namespace

double least_dihedral_sine(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // sin of the angle at an edge of length L between faces of areas A, B: 3 V L / (2 A B).
  const std::array<Vec3, 4> x{a, b, c, d};
  const std::array<Vec3, 4> normals = outward_normals(x);
  const double six_volumes = dot(cross(b - a, c - a), d - a);
  double squared[4];
  for (std::size_t f = 0; f < 4; ++f) squared[f] = norm_squared(normals[f]);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      // Faces i and j meet in the edge between the other two corners.
      const std::size_t p = i == 0 ? (j == 1 ? 2 : 1) : 0;
      const std::size_t q = 6 - i - j - p;
      const double product = squared[i] * squared[j];
      if (!(product > 0.0)) return six_volumes > 0.0 ? 0.0 : -1.0;
      least = std::min(least, norm_squared(x[p] - x[q]) / product);
    }
  return six_volumes * std::sqrt(least);
}

DihedralRange dihedral_range(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::array<Vec3, 4> normals = outward_normals({a, b, c, d});
  DihedralRange range;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double angle =
          std::atan2(norm(cross(normals[i], normals[j])), -dot(normals[i], normals[j])) * 180.0 /
          std::numbers::pi;
      range.least = std::min(range.least, angle);
      range.greatest = std::max(range.greatest, angle);
    }
  return range;
}

}  // namespace angio::air_mesh

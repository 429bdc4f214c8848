#include "meshing/detail/outward_cone.hpp"

#include <algorithm>

namespace angio::meshing::detail {
namespace {

double least_cosine(const std::vector<Vec3>& normals, const Vec3& direction) {
  double least = 1.0;
  for (const Vec3& normal : normals) least = std::min(least, dot(normal, direction));
  return least;
}

}  // namespace

Outward most_normal(const std::vector<Vec3>& normals) {
  Outward best{{}, -2.0};
  const auto consider = [&](const Vec3& candidate) {
    const double length = norm(candidate);
    if (!(length > 1e-9)) return;
    const double least = least_cosine(normals, candidate / length);
    if (least > best.rise) best = {candidate / length, least};
  };
  // The narrowest cone touches two of the normals, or three; all of them alike touch one.
  for (std::size_t a = 0; a < normals.size(); ++a) {
    consider(normals[a]);
    for (std::size_t b = a + 1; b < normals.size(); ++b) {
      consider(normals[a] + normals[b]);
      for (std::size_t c = b + 1; c < normals.size(); ++c) {
        const Vec3 axis = cross(normals[b] - normals[a], normals[c] - normals[a]);
        consider(dot(axis, normals[a]) < 0.0 ? -1.0 * axis : axis);
      }
    }
  }
  return best;
}

Vec3 risen(const Vec3& way, const std::vector<Vec3>& normals, const Outward& outward,
           double least_rise) {
  const double length = norm(way), wanted = std::min(least_rise, outward.rise);
  if (!(length > 0.0) || least_cosine(normals, way / length) >= wanted) return way;
  double low = 0.0, high = 1.0;  // share of the turn
  const auto turned = [&](double share) {
    const Vec3 mix = ((1.0 - share) / length) * way + share * outward.direction;
    return norm(mix) > 1e-9 ? normalized(mix) : outward.direction;
  };
  constexpr int kHalvings = 20;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (least_cosine(normals, turned(middle)) >= wanted ? high : low) = middle;
  }
  return length * turned(high);
}

std::vector<std::vector<Vec3>> normals_around_vertices(const TriangleMesh& mesh) {
  std::vector<std::vector<Vec3>> around(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    const Vec3 normal = normalized(area_vector_doubled(mesh, t));
    for (const int v : t) around[std::size_t(v)].push_back(normal);
  }
  return around;
}

}  // namespace angio::meshing::detail

#include <algorithm>
#include <cmath>

#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {
namespace {

/// Directions in which vertices move: normals, within the plane of the rim for rim vertices.
std::vector<Vec3> moving_directions(const SurfaceDraft& draft) {
  std::vector<Vec3> normals = vertex_normals(draft.mesh);
  for (std::size_t v = 0; v < normals.size(); ++v) {
    if (draft.rim[v] < 0) continue;
    const Vec3& axis = draft.rim_planes[std::size_t(draft.rim[v])].normal;
    normals[v] = normalized(normals[v] - dot(normals[v], axis) * axis);
  }
  return normals;
}

}  // namespace

void smooth(SurfaceDraft& draft, int iteration_count) {
  const auto neighbors = vertex_neighbors(draft.mesh);
  std::vector<Vec3>& x = draft.mesh.vertices;
  std::vector<Vec3> step(x.size());
  for (int pass = 0; pass < 2 * iteration_count; ++pass) {
    const double factor = pass % 2 == 0 ? 0.5 : -0.53;
    const std::vector<Vec3> direction = moving_directions(draft);
    for (std::size_t v = 0; v < x.size(); ++v) {
      Vec3 sum;
      int count = 0;
      for (const int n : neighbors[v]) {
        if (draft.rim[v] >= 0 && draft.rim[std::size_t(n)] != draft.rim[v]) continue;
        sum += x[std::size_t(n)];
        ++count;
      }
      step[v] = Vec3{};
      if (count > 0)
        step[v] = factor * dot((1.0 / count) * sum - x[v], direction[v]) * direction[v];
    }
    for (std::size_t v = 0; v < x.size(); ++v) x[v] += step[v];
  }
}

void balance_volume(SurfaceDraft& draft, const SurfaceTarget& target) {
  std::vector<Vec3>& x = draft.mesh.vertices;
  for (int pass = 0; pass < 3; ++pass) {
    const std::vector<Vec3> direction = moving_directions(draft);
    std::vector<double> sum(x.size(), 0.0);
    std::vector<double> weight(x.size(), 0.0);
    for (const Triangle& t : draft.mesh.triangles) {
      // Edge middles integrate quadratics over a triangle exactly.
      double mean = 0.0;
      for (std::size_t c = 0; c < 3; ++c)
        mean += target.evaluate(0.5 * (x[std::size_t(t[c])] + x[std::size_t(t[(c + 1) % 3])]))
                    .signed_distance /
                3.0;
      const double area = norm(area_vector_doubled(draft.mesh, t));
      for (const int v : t) {
        sum[std::size_t(v)] += area * mean;
        weight[std::size_t(v)] += area;
      }
    }
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (!(weight[v] > 0.0)) continue;
      const double limit = 0.2 * draft.edge_length[v];
      x[v] -= std::clamp(sum[v] / weight[v], -limit, limit) * direction[v];
    }
  }
}

}  // namespace angio::meshing::detail

#include <algorithm>
#include <cmath>

#include "air_mesh/build/surface_crossings.hpp"
#include "core/parallel.hpp"
#include "meshing/detail/patch.hpp"
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

/// Taubin's two steps along the normals.
void smooth_along_normals(SurfaceDraft& draft, int iteration_count) {
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

/// Where smoothing left the target by more than the tolerance, vertices go back as far as needed.
void keep_near(SurfaceDraft& draft, const SurfaceTarget& target, double tolerance) {
  if (!std::isfinite(tolerance)) return;
  std::vector<Vec3>& x = draft.mesh.vertices;
  parallel_for(std::ptrdiff_t(x.size()), [&](std::ptrdiff_t i) {
    const auto v = std::size_t(i);
    const double off = target.evaluate(x[v]).signed_distance;
    if (std::abs(off) <= tolerance) return;
    const double level = std::copysign(tolerance, off);
    const double step = 0.5 * draft.edge_length[v];
    if (draft.rim[v] < 0) {
      x[v] = target.project(x[v], step, level).point;
    } else {
      const Vec3& axis = draft.rim_planes[std::size_t(draft.rim[v])].normal;
      x[v] = target.project_in_plane(x[v], axis, step, level).point;
    }
  });
}

/// Mean signed distance from the target over each triangle.
std::vector<double> mean_distances(const TriangleMesh& mesh, const SurfaceTarget& target) {
  const std::vector<Vec3>& x = mesh.vertices;
  std::vector<double> means(mesh.triangles.size(), 0.0);
  parallel_for(std::ptrdiff_t(means.size()), [&](std::ptrdiff_t i) {
    const Triangle& t = mesh.triangles[std::size_t(i)];
    // Edge middles integrate quadratics over a triangle exactly.
    for (std::size_t c = 0; c < 3; ++c)
      means[std::size_t(i)] +=
          target.evaluate(0.5 * (x[std::size_t(t[c])] + x[std::size_t(t[(c + 1) % 3])]))
              .signed_distance /
          3.0;
  });
  return means;
}

/// Moves vertices along their normals until triangles lie as much outside as inside the target, so
/// that flat triangles enclose the volume of the curved surface. A regular n-gon in a circle would
/// lose (2 pi / n)^2 / 6 of the area: 2.6 % at n = 16.
void balance_volume(SurfaceDraft& draft, const SurfaceTarget& target) {
  std::vector<Vec3>& x = draft.mesh.vertices;
  for (int pass = 0; pass < 3; ++pass) {
    const std::vector<Vec3> direction = moving_directions(draft);
    std::vector<double> sum(x.size(), 0.0);
    std::vector<double> weight(x.size(), 0.0);
    const std::vector<double> means = mean_distances(draft.mesh, target);
    for (std::size_t i = 0; i < draft.mesh.triangles.size(); ++i) {
      const Triangle& t = draft.mesh.triangles[i];
      const double mean = means[i];
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

/// Vertices around crossing triangles go back to where they were. What crossed before is left.
void undo_crossings(SurfaceDraft& draft, const std::vector<Vec3>& before) {
  constexpr int kPasses = 3;
  std::vector<char> changed(draft.mesh.triangles.size(), 1);
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto pairs = air_mesh::self_intersections_of(draft.mesh, changed);
    if (pairs.empty()) return;
    std::vector<char> near = mark_corners(draft.mesh, pairs);
    grow(draft.mesh, near, 1 + pass);
    for (std::size_t v = 0; v < near.size(); ++v) {
      near[v] = near[v] && !(draft.mesh.vertices[v] == before[v]);
      if (near[v]) draft.mesh.vertices[v] = before[v];
    }
    for (std::size_t t = 0; t < changed.size(); ++t) {
      const Triangle& c = draft.mesh.triangles[t];
      changed[t] = near[std::size_t(c[0])] || near[std::size_t(c[1])] || near[std::size_t(c[2])];
    }
  }
}

}  // namespace

void smooth(SurfaceDraft& draft, const SurfaceTarget& target, int iteration_count,
            double tolerance) {
  const std::vector<Vec3> before = draft.mesh.vertices;
  smooth_along_normals(draft, iteration_count);
  keep_near(draft, target, tolerance);
  balance_volume(draft, target);
  undo_crossings(draft, before);
}

}  // namespace angio::meshing::detail

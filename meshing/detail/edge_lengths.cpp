#include "meshing/detail/edge_lengths.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <utility>

#include "core/parallel.hpp"
#include "core/statistics.hpp"
#include "meshing/detail/nearest_line.hpp"

namespace angio::meshing::detail {

std::vector<double> mean_edge_lengths(const TriangleMesh& mesh) {
  std::vector<double> sum(mesh.vertices.size(), 0.0);
  std::vector<int> count(mesh.vertices.size(), 0);
  for (const auto& [a, b] : unique_edges(mesh))
    for (const int v : {a, b}) {
      sum[std::size_t(v)] += distance(mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)]);
      ++count[std::size_t(v)];
    }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] /= std::max(1, count[v]);
  return sum;
}

void limit_growth(const TriangleMesh& mesh, std::vector<double>& lengths) {
  constexpr double kGrowth = 0.2;
  const auto neighbors = vertex_neighbors(mesh);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::size_t v = 0; v < lengths.size(); ++v) queue.push({lengths[v], int(v)});
  while (!queue.empty()) {
    const auto [length, v] = queue.top();
    queue.pop();
    if (length > lengths[std::size_t(v)]) continue;
    for (const int u : neighbors[std::size_t(v)]) {
      const double limit =
          length + kGrowth * distance(mesh.vertices[std::size_t(v)], mesh.vertices[std::size_t(u)]);
      if (limit >= lengths[std::size_t(u)]) continue;
      lengths[std::size_t(u)] = limit;
      queue.push({limit, u});
    }
  }
}

double greatest_curvature(const SurfaceTarget& target, const Vec3& point, double step) {
  const Vec3 normal = target.evaluate(point).normal;
  const Vec3 u = any_perpendicular(normal);
  const Vec3 v = cross(normal, u);
  const auto change = [&](const Vec3& along) {
    return (target.evaluate(point + step * along).normal -
            target.evaluate(point - step * along).normal) /
           (2.0 * step);
  };
  const Vec3 du = change(u);
  const Vec3 dv = change(v);
  const double mean = 0.5 * (dot(du, u) + dot(dv, v));
  const double half = 0.5 * (dot(du, u) - dot(dv, v));
  const double mixed = 0.5 * (dot(du, v) + dot(dv, u));
  return std::abs(mean) + std::hypot(half, mixed);
}

namespace {

double median_radius(const CenterlineTree& tree) {
  std::vector<double> radii;
  for (const CenterlinePath& path : tree.paths)
    radii.insert(radii.end(), path.inscribed_radius.begin(), path.inscribed_radius.end());
  return median(std::move(radii));
}

}  // namespace

void set_edge_lengths(SurfaceDraft& draft, const SurfaceTarget& target, const CenterlineTree& tree,
                      const LumenMeshOptions& options, double least_length,
                      std::vector<std::string>& warnings) {
  constexpr double kLeastShare = 0.4;    // of the length by the line's radius: noise is curved, too
  constexpr double kLeastRadius = 0.02;  // of the median
  constexpr double kSlack = 1.5;         // a round vessel is left to its radius
  const TriangleMesh& mesh = draft.mesh;
  draft.edge_length.assign(mesh.vertices.size(), options.edge_length_mm);
  if (options.edge_length_mm == 0.0) {
    const NearestLine lines(tree);
    const double least_radius = kLeastRadius * median_radius(tree);
    const double per_radius = 2.0 * std::numbers::pi / options.edges_per_circumference;
    parallel_for(std::ptrdiff_t(mesh.vertices.size()), [&](std::ptrdiff_t i) {
      const Vec3& x = mesh.vertices[std::size_t(i)];
      const LinePlace place = lines.find(x);
      // Where a line ends on a cap its inscribed radius is none.
      const double radius = std::max({place.radius, 0.3 * place.distance, least_radius});
      const double by_radius = per_radius * radius;
      const double step = std::max(0.5 * by_radius, least_length);
      const double by_curvature = kSlack * per_radius / greatest_curvature(target, x, step);
      draft.edge_length[std::size_t(i)] =
          std::max(least_length, std::clamp(by_curvature, kLeastShare * by_radius, by_radius));
    });
    limit_growth(mesh, draft.edge_length);
  }
  const std::vector<double> areas = vertex_areas(mesh);
  double count = 0.0;  // equilateral triangles have sqrt(3)/4 L^2; remeshing leaves edges near L
  for (std::size_t v = 0; v < areas.size(); ++v)
    count += areas[v] / (0.25 * std::numbers::sqrt3 * draft.edge_length[v] * draft.edge_length[v]);
  const double share = 1.15 * count / options.triangle_budget;
  if (share <= 1.0) return;
  for (double& length : draft.edge_length) length *= std::sqrt(share);
  warnings.push_back("the lumen's edges were lengthened by " +
                     std::to_string(std::lround(100.0 * (std::sqrt(share) - 1.0))) +
                     " % to keep the triangle budget");
}

}  // namespace angio::meshing::detail

#include "meshing/detail/edge_lengths.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

#include "meshing/detail/nearest_line.hpp"

namespace angio::meshing::detail {

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

void set_edge_lengths(SurfaceDraft& draft, const CenterlineTree& tree,
                      const LumenMeshOptions& options, double least_length,
                      std::vector<std::string>& warnings) {
  const TriangleMesh& mesh = draft.mesh;
  draft.edge_length.assign(mesh.vertices.size(), options.edge_length_mm);
  if (options.edge_length_mm == 0.0) {
    const NearestLine lines(tree);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      draft.edge_length[v] =
          std::max(least_length, 2.0 * std::numbers::pi * lines.find(mesh.vertices[v]).radius /
                                     options.edges_per_circumference);
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

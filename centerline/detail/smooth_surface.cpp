#include "centerline/detail/smooth_surface.hpp"

#include <algorithm>
#include <utility>

#include "core/statistics.hpp"

namespace angio::centerline {
namespace {

using Neighbors = std::vector<std::vector<int>>;

/// From each vertex to the middle of its neighbours.
std::vector<Vec3> umbrellas(const std::vector<Vec3>& points, const Neighbors& neighbors) {
  std::vector<Vec3> steps(points.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (neighbors[v].empty()) continue;
    Vec3 middle;
    for (const int n : neighbors[v]) middle += points[std::size_t(n)];
    steps[v] = middle / double(neighbors[v].size()) - points[v];
  }
  return steps;
}

}  // namespace

double roughness(const TriangleMesh& mesh) {
  const Neighbors neighbors = vertex_neighbors(mesh);
  const std::vector<Vec3> bends = umbrellas(umbrellas(mesh.vertices, neighbors), neighbors);
  double edges = 0.0;
  std::size_t edge_count = 0;
  std::vector<double> size;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (neighbors[v].empty()) continue;
    size.push_back(norm(bends[v]));
    for (const int n : neighbors[v])
      edges += distance(mesh.vertices[v], mesh.vertices[std::size_t(n)]);
    edge_count += neighbors[v].size();
  }
  if (size.empty() || edges <= 0.0) return 0.0;
  return median(std::move(size)) * double(edge_count) / edges;
}

void smooth_surface(TriangleMesh& mesh, int rounds) {
  const Neighbors neighbors = vertex_neighbors(mesh);
  for (int round = 0; round < rounds; ++round)
    for (const double step : {0.5, -0.53}) {
      const std::vector<Vec3> steps = umbrellas(mesh.vertices, neighbors);
      for (std::size_t v = 0; v < steps.size(); ++v) mesh.vertices[v] += step * steps[v];
    }
}

}  // namespace angio::centerline

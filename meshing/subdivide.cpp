#include "meshing/subdivide.hpp"

#include <algorithm>
#include <array>

namespace angio::meshing {

TriangleMesh subdivide(const TriangleMesh& mesh) {
  const std::vector<std::array<int, 2>> edges = unique_edges(mesh);
  TriangleMesh fine;
  fine.vertices = mesh.vertices;
  for (const auto& [a, b] : edges)
    fine.vertices.push_back(0.5 * (mesh.vertices[std::size_t(a)] + mesh.vertices[std::size_t(b)]));
  const auto middle = [&](int a, int b) {
    const std::array<int, 2> edge{std::min(a, b), std::max(a, b)};
    return int(mesh.vertices.size()) +
           int(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin());
  };
  for (const Triangle& t : mesh.triangles) {
    const int ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
    fine.triangles.insert(fine.triangles.end(),
                          {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
  }
  return fine;
}

std::vector<std::array<int, 2>> edges_to_halve(TriangleMesh lumen, double least_radius_mm) {
  constexpr double kEdgeInRadii = 0.4;  // as the program's own meshes have it
  constexpr int kMostLevels = 2;
  std::vector<std::array<int, 2>> halved;
  for (int level = 0; level < kMostLevels; ++level) {
    double sum = 0.0;
    const auto edges = unique_edges(lumen);
    for (const auto& [a, b] : edges)
      sum += distance(lumen.vertices[std::size_t(a)], lumen.vertices[std::size_t(b)]);
    if (sum <= kEdgeInRadii * least_radius_mm * double(edges.size())) break;
    halved.insert(halved.end(), edges.begin(), edges.end());
    lumen = subdivide(lumen);
  }
  return halved;
}

}  // namespace angio::meshing

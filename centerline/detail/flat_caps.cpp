#include "centerline/detail/flat_caps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/units.hpp"

namespace angio::centerline {
namespace {

/// Whether a flat piece is where a vessel was cut off.
bool is_cap(const TriangleMesh& mesh, const std::vector<std::array<int, 3>>& neighbors,
            const std::vector<int>& piece, const std::vector<int>& piece_of,
            const std::vector<Vec3>& normals, double mean_edge) {
  constexpr double kSharp = 0.866, kMostOfRim = 0.9, kRound = 0.4, kWide = 2.0;
  double area = 0.0, rim = 0.0, sharp = 0.0;
  Vec3 normal;
  for (const int t : piece) {
    const Vec3 doubled = area_vector_doubled(mesh, mesh.triangles[std::size_t(t)]);
    normal += doubled;
    area += 0.5 * norm(doubled);
  }
  normal = normalized(normal);
  for (const int t : piece)
    for (std::size_t c = 0; c < 3; ++c) {
      const Triangle& corners = mesh.triangles[std::size_t(t)];
      const int a = corners[c], b = corners[(c + 1) % 3];
      const int beside = neighbors[std::size_t(t)][c];
      if (beside >= 0 && piece_of[std::size_t(beside)] == piece_of[std::size_t(t)]) continue;
      const Vec3& from = mesh.vertices[std::size_t(a)];
      const double length = distance(from, mesh.vertices[std::size_t(b)]);
      rim += length;
      if (beside < 0 || dot(normals[std::size_t(beside)], normal) > kSharp) continue;
      for (const int v : mesh.triangles[std::size_t(beside)])
        if (v != a && v != b && dot(mesh.vertices[std::size_t(v)] - from, normal) < 0.0)
          sharp += length;
    }
  return rim > 0.0 && sharp > kMostOfRim * rim && 4.0 * units::kPi * area > kRound * rim * rim &&
         std::sqrt(area / units::kPi) > kWide * mean_edge;
}

}  // namespace

TriangleMesh remove_flat_caps(const TriangleMesh& closed) {
  constexpr double kFlat = 0.9986;  // cosine of 3 degrees
  const auto neighbors = triangle_neighbors(closed);
  const auto edges = unique_edges(closed);
  double length = 0.0;
  for (const auto& [a, b] : edges)
    length += distance(closed.vertices[std::size_t(a)], closed.vertices[std::size_t(b)]);
  const double mean_edge = edges.empty() ? 0.0 : length / double(edges.size());
  std::vector<Vec3> normals;
  for (const Triangle& t : closed.triangles)
    normals.push_back(normalized(area_vector_doubled(closed, t)));
  std::vector<int> piece_of(closed.triangles.size(), -1);
  std::vector<char> is_removed(closed.triangles.size(), 0);
  int piece_count = 0;
  for (std::size_t seed = 0; seed < piece_of.size(); ++seed) {
    if (piece_of[seed] >= 0) continue;
    std::vector<int> piece{int(seed)};
    piece_of[seed] = piece_count;
    for (std::size_t next = 0; next < piece.size(); ++next) {
      const std::array<int, 3> around = neighbors[std::size_t(piece[next])];
      for (const int beside : around) {
        if (beside < 0 || piece_of[std::size_t(beside)] >= 0 ||
            dot(normals[std::size_t(beside)], normals[seed]) < kFlat)
          continue;
        piece_of[std::size_t(beside)] = piece_count;
        piece.push_back(beside);
      }
    }
    if (is_cap(closed, neighbors, piece, piece_of, normals, mean_edge))
      for (const int t : piece) is_removed[std::size_t(t)] = 1;
    ++piece_count;
  }
  TriangleMesh open;
  open.vertices = closed.vertices;
  for (std::size_t t = 0; t < is_removed.size(); ++t)
    if (is_removed[t] == 0) open.triangles.push_back(closed.triangles[t]);
  return open;
}

}  // namespace angio::centerline

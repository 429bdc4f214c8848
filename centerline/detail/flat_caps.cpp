#include "centerline/detail/flat_caps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/units.hpp"

namespace angio::centerline {
namespace {

/// Whether a flat piece is where a vessel was cut off: with a sharp edge, and its radius two edges
/// of its own rim or of the mesh (a thin vessel beside wide ones is of finer triangles) and about
/// round, or its rim six edges or more and as good as a circle's polygon.
bool is_cap(const TriangleMesh& mesh, const std::vector<std::array<int, 3>>& neighbors,
            const std::vector<int>& piece, const std::vector<int>& piece_of,
            const std::vector<Vec3>& normals, double mean_edge) {
  constexpr double kSharp = 0.866, kMostOfRim = 0.9;
  constexpr double kRound = 0.4, kWide = 2.0, kPolygon = 0.85, kSixEdges = 0.85;
  double area = 0.0, rim = 0.0, sharp = 0.0;
  int rim_edges = 0;
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
      ++rim_edges;
      if (beside < 0 || dot(normals[std::size_t(beside)], normal) > kSharp) continue;
      for (const int v : mesh.triangles[std::size_t(beside)])
        if (v != a && v != b && dot(mesh.vertices[std::size_t(v)] - from, normal) < 0.0)
          sharp += length;
    }
  if (!(sharp > kMostOfRim * rim)) return false;
  const double roundness = 4.0 * units::kPi * area / (rim * rim);
  const double radius = std::sqrt(area / units::kPi), rim_edge = rim / double(rim_edges);
  return (roundness > kRound && radius > kWide * std::min(mean_edge, rim_edge)) ||
         (roundness > kPolygon && radius > kSixEdges * rim_edge);
}

/// The triangles' unit normals, each the mean of its own and its neighbours', some times over:
/// a smoothed surface still shows its voxels' steps.
std::vector<Vec3> smooth_normals(const TriangleMesh& mesh,
                                 const std::vector<std::array<int, 3>>& neighbors, int rounds) {
  std::vector<Vec3> doubled;
  for (const Triangle& t : mesh.triangles) doubled.push_back(area_vector_doubled(mesh, t));
  for (int round = 0; round < rounds; ++round) {
    const std::vector<Vec3> before = doubled;
    for (std::size_t t = 0; t < doubled.size(); ++t)
      for (const int beside : neighbors[t])
        if (beside >= 0) doubled[t] += before[std::size_t(beside)];
  }
  for (Vec3& normal : doubled) normal = normalized(normal);
  return doubled;
}

/// The triangles that hang together with some and turn by no more than an angle from a direction.
class Regions {
 public:
  Regions(const TriangleMesh& mesh, std::vector<std::array<int, 3>> neighbors,
          std::vector<Vec3> normals)
      : mesh_(mesh),
        neighbors_(std::move(neighbors)),
        normals_(std::move(normals)),
        mark_(mesh.triangles.size(), 0) {}

  [[nodiscard]] const Vec3& normal(int t) const { return normals_[std::size_t(t)]; }
  std::vector<int> grow(std::vector<int> region, const Vec3& direction, double cosine) {
    ++stamp_;
    for (const int t : region) mark_[std::size_t(t)] = stamp_;
    for (std::size_t next = 0; next < region.size(); ++next) {
      const std::array<int, 3> around = neighbors_[std::size_t(region[next])];
      for (const int beside : around) {
        if (beside < 0 || mark_[std::size_t(beside)] == stamp_) continue;
        if (dot(normals_[std::size_t(beside)], direction) < cosine) continue;
        mark_[std::size_t(beside)] = stamp_;
        region.push_back(beside);
      }
    }
    return region;
  }
  [[nodiscard]] double area(const std::vector<int>& region) const {
    double sum = 0.0;
    for (const int t : region)
      sum += 0.5 * norm(area_vector_doubled(mesh_, mesh_.triangles[std::size_t(t)]));
    return sum;
  }
  [[nodiscard]] Vec3 mean_normal(const std::vector<int>& region) const {
    Vec3 sum;
    for (const int t : region) sum += area_vector_doubled(mesh_, mesh_.triangles[std::size_t(t)]);
    return normalized(sum);
  }
  [[nodiscard]] Vec3 middle(const std::vector<int>& region) const {
    Vec3 sum;
    for (const int t : region) {
      const Triangle& corners = mesh_.triangles[std::size_t(t)];
      const double weight = norm(area_vector_doubled(mesh_, corners));
      for (const int v : corners) sum += weight / 3.0 * mesh_.vertices[std::size_t(v)];
    }
    return sum / (2.0 * area(region));
  }
  /// The share of a region's area within the disc of that area around its middle: 1 of a disc.
  [[nodiscard]] double roundness(const std::vector<int>& region) const {
    const Vec3 center = middle(region);
    const double whole = area(region), radius = std::sqrt(whole / units::kPi);
    std::vector<int> inside;
    for (const int t : region) {
      Vec3 at;
      for (const int v : mesh_.triangles[std::size_t(t)])
        at += mesh_.vertices[std::size_t(v)] / 3.0;
      if (distance(at, center) < radius) inside.push_back(t);
    }
    return area(inside) / whole;
  }

 private:
  const TriangleMesh& mesh_;
  std::vector<std::array<int, 3>> neighbors_;
  std::vector<Vec3> normals_;
  std::vector<int> mark_;
  int stamp_ = 0;
};

double mean_edge_of(const TriangleMesh& mesh) {
  const auto edges = unique_edges(mesh);
  double length = 0.0;
  for (const auto& [a, b] : edges)
    length += distance(mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)]);
  return edges.empty() ? 0.0 : length / double(edges.size());
}

}  // namespace

std::vector<OpenRim> find_flat_ends(const TriangleMesh& closed) {
  constexpr double kFlat = 0.985, kEdge = 0.5;  // cosines of 10 and 60 degrees
  constexpr double kMostWithEdge = 3.0, kRound = 0.75, kRoundInside = 0.6, kWide = 3.0;
  constexpr int kRounds = 3;
  const auto neighbors = triangle_neighbors(closed);
  Regions regions(closed, neighbors, smooth_normals(closed, neighbors, kRounds));
  const double least = units::kPi * std::pow(kWide * mean_edge_of(closed), 2);
  std::vector<char> is_seen(closed.triangles.size(), 0);
  const auto see = [&](const std::vector<int>& region) {
    for (const int t : region) is_seen[std::size_t(t)] = 1;
  };
  std::vector<OpenRim> ends;
  for (std::size_t seed = 0; seed < is_seen.size(); ++seed) {
    if (is_seen[seed] != 0) continue;
    std::vector<int> flat = regions.grow({int(seed)}, regions.normal(int(seed)), kFlat);
    see(flat);
    if (regions.area(flat) < 0.5 * least) continue;
    // Again around the mean: a seed at the edge sees but a part.
    const Vec3 normal = regions.mean_normal(flat);
    const auto straightest = std::max_element(flat.begin(), flat.end(), [&](int a, int b) {
      return dot(regions.normal(a), normal) < dot(regions.normal(b), normal);
    });
    flat = regions.grow({*straightest}, normal, kFlat);
    if (regions.area(flat) < least || regions.roundness(flat) < kRoundInside) continue;
    const std::vector<int> whole = regions.grow(flat, normal, kEdge);
    if (regions.area(whole) > kMostWithEdge * regions.area(flat) ||
        regions.roundness(whole) < kRound)
      continue;
    see(whole);
    ends.push_back({regions.middle(flat), std::sqrt(regions.area(whole) / units::kPi)});
  }
  return ends;
}

TriangleMesh remove_flat_caps(const TriangleMesh& closed) {
  constexpr double kFlat = 0.9986;  // cosine of 3 degrees
  const auto neighbors = triangle_neighbors(closed);
  const double mean_edge = mean_edge_of(closed);
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

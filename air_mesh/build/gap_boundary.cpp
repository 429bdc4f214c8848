#include "air_mesh/build/gap_boundary.hpp"

#include <utility>

#include "air_mesh/build/surface_crossings.hpp"
#include "air_mesh/build/triangulate_loop.hpp"
#include "air_mesh/build/whole_piece.hpp"

namespace angio::air_mesh {
namespace {

/// A part of the wall, and which of the wall's vertices its own are.
struct WallPart {
  TriangleMesh mesh;
  std::vector<int> wall_vertex;
};

/// The part that some of its triangles make, with the vertices in the same order.
WallPart part_of(const WallPart& whole, const std::vector<Triangle>& triangles) {
  std::vector<int> index(whole.mesh.vertices.size(), -1);
  for (const Triangle& t : triangles)
    for (const int v : t) index[std::size_t(v)] = 0;
  WallPart part;
  for (std::size_t v = 0; v < index.size(); ++v) {
    if (index[v] < 0) continue;
    index[v] = int(part.mesh.vertices.size());
    part.mesh.vertices.push_back(whole.mesh.vertices[v]);
    part.wall_vertex.push_back(whole.wall_vertex[v]);
  }
  for (const Triangle& t : triangles)
    part.mesh.triangles.push_back(
        {index[std::size_t(t[0])], index[std::size_t(t[1])], index[std::size_t(t[2])]});
  return part;
}

/// The triangles of a part that no cap crosses: of those that cross each other, and, where one is a
/// cap's, of those around its corners, none is left.
std::vector<Triangle> clear_of_caps(const TriangleMesh& part, const GapBoundary& gap,
                                    const std::vector<std::array<int, 2>>& crossings) {
  std::vector<char> touched(part.vertices.size(), 0);
  std::vector<char> is_crossed(part.triangles.size(), 0);
  for (const auto& pair : crossings)
    for (const int t : pair) {
      if (t < gap.cap_first)
        is_crossed[std::size_t(t)] = 1;
      else
        for (const int v : gap.shell.triangles[std::size_t(t)]) touched[std::size_t(v)] = 1;
    }
  std::vector<Triangle> clear;
  for (std::size_t t = 0; t < part.triangles.size(); ++t) {
    bool is_clear = is_crossed[t] == 0;
    for (const int v : part.triangles[t]) is_clear = is_clear && touched[std::size_t(v)] == 0;
    if (is_clear) clear.push_back(part.triangles[t]);
  }
  return clear;
}

}  // namespace

std::optional<GapBoundary> close_region(const TriangleMesh& region) {
  GapBoundary gap{region, int(region.triangles.size())};
  for (const std::vector<int>& loop : boundary_loops(region)) {
    std::vector<Vec3> points;
    for (const int v : loop) points.push_back(region.vertices[std::size_t(v)]);
    const std::vector<Triangle> patch = triangulate_loop(points);
    if (patch.empty()) return std::nullopt;
    for (const Triangle& t : patch)
      gap.shell.triangles.push_back(
          {loop[std::size_t(t[0])], loop[std::size_t(t[1])], loop[std::size_t(t[2])]});
  }
  return gap;
}

std::vector<Triangle> ClosedWall::wall_triangles() const {
  std::vector<Triangle> triangles;
  for (std::size_t t = 0; t < std::size_t(boundary.cap_first); ++t) {
    const Triangle& own = boundary.shell.triangles[t];
    triangles.push_back({wall_vertex[std::size_t(own[0])], wall_vertex[std::size_t(own[1])],
                         wall_vertex[std::size_t(own[2])]});
  }
  return triangles;
}

std::optional<ClosedWall> close_wall(const TriangleMesh& wall) {
  constexpr int kAttempts = 10;
  WallPart part{wall, {}};
  for (std::size_t v = 0; v < wall.vertices.size(); ++v) part.wall_vertex.push_back(int(v));
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    auto gap = close_region(part.mesh);
    if (!gap) return std::nullopt;
    const auto crossings = self_intersections(gap->shell);
    if (crossings.empty()) return ClosedWall{std::move(*gap), std::move(part.wall_vertex)};
    std::vector<Triangle> clear = clear_of_caps(part.mesh, *gap, crossings);
    make_whole(clear, part.mesh.vertices.size());
    part = part_of(part, clear);
    if (part.mesh.triangles.empty()) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace angio::air_mesh

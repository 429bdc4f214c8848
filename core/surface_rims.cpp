#include "core/surface_rims.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/units.hpp"

namespace angio {
namespace {

/// The corner of the wall's triangle across each edge of a rim, by the edge's ends as a rim has
/// them.
using AcrossRim = std::map<std::pair<int, int>, int>;

AcrossRim corners_across(const TriangleMesh& mesh, const std::vector<std::vector<int>>& loops) {
  std::vector<char> on_rim(mesh.vertices.size(), 0);
  for (const auto& loop : loops)
    for (const int v : loop) on_rim[std::size_t(v)] = 1;
  AcrossRim across;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = t[c], b = t[(c + 1) % 3];
      if (on_rim[std::size_t(a)] && on_rim[std::size_t(b)]) across[{b, a}] = t[(c + 2) % 3];
    }
  return across;
}

/// Sum over the rim of ds c.
Vec3 pull_of_wall(const TriangleMesh& mesh, const std::vector<int>& loop, const AcrossRim& across) {
  Vec3 pull;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const int a = loop[i], b = loop[(i + 1) % loop.size()];
    const auto found = across.find({a, b});
    if (found == across.end()) continue;
    const Vec3& from = mesh.vertices[std::size_t(a)];
    const Vec3 along = normalized(mesh.vertices[std::size_t(b)] - from);
    Vec3 away = from - mesh.vertices[std::size_t(found->second)];
    away -= dot(away, along) * along;
    pull += distance(from, mesh.vertices[std::size_t(b)]) * normalized(away);
  }
  return pull;
}

SurfaceRim describe(const TriangleMesh& mesh, std::vector<int> loop, const AcrossRim& across) {
  SurfaceRim rim;
  const auto at = [&](std::size_t i) { return mesh.vertices[std::size_t(loop[i % loop.size()])]; };
  Vec3 middle;
  double perimeter = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    middle += at(i) / double(loop.size());
    perimeter += distance(at(i), at(i + 1));
  }
  Vec3 area_doubled;
  for (std::size_t i = 0; i < loop.size(); ++i)
    area_doubled += cross(at(i) - middle, at(i + 1) - middle);
  rim.normal = normalized(area_doubled);
  const double area = 0.5 * norm(area_doubled);
  rim.diameter_mm = 2.0 * std::sqrt(area / units::kPi);
  rim.centre = middle;
  if (area > 0.0) {
    Vec3 moment;
    for (std::size_t i = 0; i < loop.size(); ++i)
      moment += 0.5 * dot(cross(at(i) - middle, at(i + 1) - middle), rim.normal) / 3.0 *
                (at(i) + at(i + 1) - 2.0 * middle);
    rim.centre += moment / area;
  }
  for (std::size_t i = 0; i < loop.size(); ++i)
    rim.unevenness_mm = std::max(rim.unevenness_mm, std::abs(dot(at(i) - rim.centre, rim.normal)));
  const double round = std::max(2.0 * std::sqrt(units::kPi * area), 0.5 * perimeter);
  rim.wall_along = round > 0.0 ? dot(pull_of_wall(mesh, loop, across), rim.normal) / round : 0.0;
  rim.loop = std::move(loop);
  return rim;
}

}  // namespace

std::vector<SurfaceRim> surface_rims(const TriangleMesh& mesh) {
  std::vector<std::vector<int>> loops = boundary_loops(mesh);
  const AcrossRim across = corners_across(mesh, loops);
  std::vector<SurfaceRim> rims;
  rims.reserve(loops.size());
  for (std::vector<int>& loop : loops) rims.push_back(describe(mesh, std::move(loop), across));
  return rims;
}

}  // namespace angio

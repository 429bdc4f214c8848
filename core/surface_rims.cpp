#include "core/surface_rims.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
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

/// The wall around rims, without what is nearest to them.
class WallInside {
 public:
  explicit WallInside(const TriangleMesh& mesh)
      : mesh_(mesh), neighbors_(vertex_neighbors(mesh)), around_(mesh.vertices.size()) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (const int v : mesh.triangles[t]) around_[std::size_t(v)].push_back(int(t));
  }

  /// The rim of the wall from a distance `inset` [mm] inside a rim on; nothing where that is not
  /// one loop around it.
  [[nodiscard]] std::optional<SurfaceRim> rim_at(const SurfaceRim& rim, double inset) const {
    const double reach = inset + std::min(2.0 * inset, 0.5 * rim.diameter_mm);
    const std::map<int, double> way = ways_from(rim.loop, reach);
    TriangleMesh ring;
    ring.vertices = mesh_.vertices;
    std::set<int> taken;
    for (const auto& entry : way)
      for (const int t : around_[std::size_t(entry.first)]) {
        const Triangle& corners = mesh_.triangles[std::size_t(t)];
        const bool is_inside = std::all_of(corners.begin(), corners.end(), [&](int v) {
          const auto found = way.find(v);
          return found == way.end() || found->second >= inset;
        });
        if (is_inside && taken.insert(t).second) ring.triangles.push_back(corners);
      }
    const std::vector<std::vector<int>> loops = boundary_loops(ring);
    if (loops.size() < 2) return std::nullopt;
    // The others are where the ring was left off: several, beside a fork.
    std::vector<std::pair<double, std::size_t>> farthest;  // way of each loop's farthest vertex
    for (std::size_t l = 0; l < loops.size(); ++l) {
      double most = 0.0;
      for (const int v : loops[l]) {
        const auto found = way.find(v);
        most = std::max(most, found == way.end() ? 1e300 : found->second);
      }
      farthest.emplace_back(most, l);
    }
    std::sort(farthest.begin(), farthest.end());
    if (loops.size() > 2 && farthest[1].first < reach) return std::nullopt;  // not one around it
    return describe(ring, loops[farthest[0].second], corners_across(ring, loops));
  }

 private:
  /// The way along edges [mm] from a rim, of the vertices within a reach (Dijkstra).
  [[nodiscard]] std::map<int, double> ways_from(const std::vector<int>& loop, double reach) const {
    std::map<int, double> way;
    std::set<std::pair<double, int>> front;
    const auto visit = [&](int v, double length) {
      const auto [found, is_new] = way.try_emplace(v, length);
      if (!is_new && found->second <= length) return;
      front.erase({found->second, v});
      found->second = length;
      front.insert({length, v});
    };
    for (const int v : loop) visit(v, 0.0);
    while (!front.empty()) {
      const auto [length, v] = *front.begin();
      front.erase(front.begin());
      for (const int next : neighbors_[std::size_t(v)]) {
        const double there =
            length + distance(mesh_.vertices[std::size_t(v)], mesh_.vertices[std::size_t(next)]);
        if (there < reach) visit(next, there);
      }
    }
    return way;
  }

  const TriangleMesh& mesh_;
  std::vector<std::vector<int>> neighbors_, around_;
};

/// Looks at rims that lean inwards a little inside, and beyond a flat lip that a cap has left;
/// not at those of a few triangles.
void look_inside(const TriangleMesh& mesh, std::vector<SurfaceRim>& rims) {
  // Around a hole in a tube's side the wall runs out the more, the farther from the hole: as much
  // as half a radius away only a tube's end shows nearly all of it. A mouth that flares does so a
  // radius inside.
  constexpr struct { double inset, least; } kLooks[] = {{0.25, 0.0}, {0.5, 0.8}, {1.0, 0.8}};
  constexpr std::size_t kFew = 8;
  std::optional<WallInside> wall;
  for (SurfaceRim& rim : rims) {
    if (rim.loop.size() < kFew || rim.wall_along >= kVesselEnd) continue;
    if (!wall) wall.emplace(mesh);
    for (const auto& look : kLooks)
      if (const auto inside = wall->rim_at(rim, look.inset * 0.5 * rim.diameter_mm);
          inside && inside->wall_along >= look.least)
        rim.wall_along = std::max(rim.wall_along, inside->wall_along);
  }
}

}  // namespace

std::vector<SurfaceRim> surface_rims(const TriangleMesh& mesh) {
  std::vector<std::vector<int>> loops = boundary_loops(mesh);
  const AcrossRim across = corners_across(mesh, loops);
  std::vector<SurfaceRim> rims;
  rims.reserve(loops.size());
  for (std::vector<int>& loop : loops) rims.push_back(describe(mesh, std::move(loop), across));
  look_inside(mesh, rims);
  return rims;
}

}  // namespace angio

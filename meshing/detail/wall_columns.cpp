#include "meshing/detail/wall_columns.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"

namespace angio::meshing::detail {
namespace {

constexpr double kStepShare = 1.0 / 32.0;   // of the wall's thickness
constexpr double kLeastStep = 1.0 / 200.0;  // of the healthy radius
constexpr double kTurnShare = 0.5;          // of it, over which a way turns to the gradient
constexpr double kReach = 3.0;              // outer radii, after which a way is given up
constexpr double kDescent = 0.25;           // of the thickness, by which a way may lead back
constexpr int kSmoothings = 8;

/// Normals without their part along the vessel, unless the surface faces along it (as a carina
/// does), and smoothed.
std::vector<Vec3> outward_directions(const TriangleMesh& lumen, const HealthyVessel& healthy,
                                     const std::vector<std::vector<int>>& neighbors) {
  std::vector<Vec3> directions = vertex_normals(lumen);
  parallel_for(std::ptrdiff_t(directions.size()), [&](std::ptrdiff_t i) {
    const auto v = std::size_t(i);
    const Vec3 tangent = healthy.evaluate(lumen.vertices[v]).tangent;
    const double along = dot(directions[v], tangent);
    const double t = std::clamp((std::abs(along) - 0.4) / 0.4, 0.0, 1.0);
    const double share = 1.0 - t * t * (3.0 - 2.0 * t);
    directions[v] = normalized(directions[v] - (share * along) * tangent);
  });
  for (int pass = 0; pass < kSmoothings; ++pass) {
    std::vector<Vec3> smoothed(directions.size());
    parallel_for(std::ptrdiff_t(directions.size()), [&](std::ptrdiff_t i) {
      const auto v = std::size_t(i);
      Vec3 sum;
      for (const int n : neighbors[v]) sum += directions[std::size_t(n)];
      smoothed[v] = normalized(directions[v] + normalized(sum));
    });
    directions = std::move(smoothed);
  }
  return directions;
}

/// The distance from the healthy tubes that counts as the healthy lumen's surface at each vertex:
/// the vertex's own, smoothed, but 0 where the lumen is narrow.
std::vector<double> healthy_levels(const TriangleMesh& lumen, const HealthyVessel& healthy,
                                   const std::vector<std::vector<int>>& neighbors) {
  std::vector<double> levels(lumen.vertices.size());
  parallel_for(std::ptrdiff_t(levels.size()), [&](std::ptrdiff_t v) {
    const HealthyPlace at = healthy.evaluate(lumen.vertices[std::size_t(v)]);
    levels[std::size_t(v)] = at.distance < 0.0 ? (1.0 - at.narrowed) * at.distance : at.distance;
  });
  for (int pass = 0; pass < kSmoothings; ++pass) {
    std::vector<double> smoothed = levels;
    for (std::size_t v = 0; v < levels.size(); ++v) {
      double sum = 0.0;
      for (const int n : neighbors[v]) sum += levels[std::size_t(n)];
      if (!neighbors[v].empty())
        smoothed[v] = 0.5 * (levels[v] + sum / double(neighbors[v].size()));
    }
    levels = std::move(smoothed);
  }
  return levels;
}

class Walk {
 public:
  Walk(const HealthyVessel& healthy, double thickness_per_radius)
      : healthy_(healthy), thickness_per_radius_(thickness_per_radius) {}

  [[nodiscard]] WallColumn from(const Vec3& start, const Vec3& direction, double level) const {
    WallColumn column;
    const auto place = [&](const Vec3& point) {
      HealthyPlace of = healthy_.evaluate(point);
      of.distance -= level;
      return of;
    };
    HealthyPlace at = place(start);
    append(column, start, at.distance);
    const double reach = kReach * (1.0 + thickness_per_radius_) * at.radius;
    const double base = std::max(0.0, at.distance);
    Vec3 along = direction;
    double highest = at.distance;
    while (true) {
      const double wanted = thickness_per_radius_ * at.radius;
      // A bump of the lumen is half as thick as the wall around it at least.
      const double target = std::max(wanted, base + 0.5 * wanted);
      highest = std::max(highest, at.distance);
      const bool stuck = at.distance > 0.0 && at.distance < highest - kDescent * wanted;
      if (at.distance >= target || stuck || column.length.back() > reach)
        return finished(std::move(column), base, target, std::min(highest, target));
      const double turn = std::clamp((at.distance - base) / (kTurnShare * wanted), 0.0, 1.0);
      if (turn > 0.0) {
        const Vec3 up = normalized(at.gradient);
        along = normalized((1.0 - turn) * direction + turn * up);
        if (dot(along, up) <= 0.0) along = up;
      }
      const double step = std::max(kStepShare * wanted, kLeastStep * at.radius);
      const Vec3 next = column.points.back() + step * along;
      at = place(next);
      append(column, next, at.distance);
    }
  }

 private:
  static void append(WallColumn& column, const Vec3& point, double distance) {
    const double step = column.points.empty() ? 0.0 : norm(point - column.points.back());
    column.length.push_back(column.points.empty() ? 0.0 : column.length.back() + step);
    column.points.push_back(point);
    column.distance.push_back(distance);
  }

  static WallColumn finished(WallColumn column, double base, double target, double reached) {
    std::size_t last_inside = column.points.size();
    for (std::size_t i = 0; i < column.points.size(); ++i)
      if (column.distance[i] < 0.0) last_inside = i;
    if (last_inside + 1 < column.points.size()) {
      const double a = column.distance[last_inside], b = column.distance[last_inside + 1];
      const double t = -a / (b - a);
      column.plaque = (1.0 - t) * column.length[last_inside] + t * column.length[last_inside + 1];
    } else if (last_inside < column.points.size()) {
      column.plaque = column.length.back();  // it never left the healthy lumen
    }
    column.thickness = std::max(0.0, reached - base);
    column.missing = target - reached;
    return column;
  }

  const HealthyVessel& healthy_;
  double thickness_per_radius_;
};

}  // namespace

std::vector<WallColumn> grow_columns(const TriangleMesh& lumen, const HealthyVessel& healthy,
                                     double thickness_per_radius) {
  const auto neighbors = vertex_neighbors(lumen);
  const auto directions = outward_directions(lumen, healthy, neighbors);
  const auto levels = healthy_levels(lumen, healthy, neighbors);
  const Walk walk(healthy, thickness_per_radius);
  std::vector<WallColumn> columns(lumen.vertices.size());
  parallel_for_uneven(std::ptrdiff_t(columns.size()), [&](std::ptrdiff_t i) {
    const auto v = std::size_t(i);
    columns[v] = walk.from(lumen.vertices[v], directions[v], levels[v]);
  });
  return columns;
}

Vec3 place_at(const WallColumn& column, double depth) {
  const auto between = [&](std::size_t a, double t) {
    return (1.0 - t) * column.points[a] + t * column.points[a + 1];
  };
  const std::size_t last = column.points.size() - 1;
  if (depth <= column.plaque)
    for (std::size_t i = 0; i < last; ++i)
      if (column.length[i + 1] >= depth)
        return between(i, (depth - column.length[i]) /
                              std::max(column.length[i + 1] - column.length[i], 1e-12));
  const double wanted = std::max(0.0, column.distance.front()) + depth - column.plaque;
  for (std::size_t i = 0; i < last; ++i)
    if (column.length[i + 1] > column.plaque && column.distance[i + 1] >= wanted)
      return between(i, std::clamp((wanted - column.distance[i]) /
                                       std::max(column.distance[i + 1] - column.distance[i], 1e-12),
                                   0.0, 1.0));
  return column.points.back();
}

}  // namespace angio::meshing::detail

#include "meshing/detail/wall_columns.hpp"

#include <algorithm>
#include <cmath>

#include "air_mesh/build/distances_ahead.hpp"
#include "core/parallel.hpp"
#include "meshing/detail/outward_cone.hpp"

namespace angio::meshing::detail {
namespace {

constexpr double kStepShare = 1.0 / 32.0;   // of the wall's thickness
constexpr double kLeastStep = 1.0 / 200.0;  // of the healthy radius
constexpr double kTurnShare = 0.5;          // of it, over which a way turns to the gradient
constexpr double kReachOfWay = 3.0;         // outer radii, after which a way is given up
constexpr double kDescent = 0.25;           // of the thickness, by which a way may lead back
constexpr double kLeastRiseOfWay = 0.3;     // sine of a way's angle to the triangles that it leaves
// Cosine between the way out of the lumen and that away from the lines, from which on the lines
// lead, and below which they do not; the way over the thickness, likewise.
constexpr double kLeads = 0.8, kMisleads = 0.5;
constexpr double kStraightWay = 1.5, kDetour = 2.0;
constexpr double kWidthShare = 0.5;  // of the lumen's width, that counts as its radius
constexpr double kRoomShare = 0.45;  // of the way to the next vessel
constexpr int kSmoothings = 8;

/// A value at each vertex drawn to the mean of its neighbours'.
template <class Value>
std::vector<Value> smoothed(std::vector<Value> values,
                            const std::vector<std::vector<int>>& neighbors) {
  for (int pass = 0; pass < kSmoothings; ++pass) {
    const std::vector<Value> before = values;
    for (std::size_t v = 0; v < values.size(); ++v) {
      if (neighbors[v].empty()) continue;
      Value sum{};
      for (const int n : neighbors[v]) sum += before[std::size_t(n)];
      values[v] = 0.5 * (before[v] + (1.0 / double(neighbors[v].size())) * sum);
    }
  }
  return values;
}

/// Normals without their part along the vessel, unless the surface faces along it (as a carina
/// does), smoothed, and rising from every triangle around.
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
  const auto normals = normals_around_vertices(lumen);
  parallel_for(std::ptrdiff_t(directions.size()), [&](std::ptrdiff_t i) {
    const auto v = std::size_t(i);
    directions[v] = risen(directions[v], normals[v], most_normal(normals[v]), kLeastRiseOfWay);
  });
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
  return smoothed(std::move(levels), neighbors);
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
    const double reach = kReachOfWay * (1.0 + thickness_per_radius_) * at.radius;
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

double between(double value, double none, double whole) {
  return std::clamp((value - none) / (whole - none), 0.0, 1.0);
}

/// How much of each way the lines do not lead, 0 to 1.
std::vector<double> misled(const std::vector<WallColumn>& columns,
                           const std::vector<Vec3>& directions, const HealthyVessel& healthy,
                           double thickness_per_radius) {
  std::vector<double> share(columns.size());
  parallel_for(std::ptrdiff_t(share.size()), [&](std::ptrdiff_t i) {
    const auto v = std::size_t(i);
    const HealthyPlace at = healthy.evaluate(columns[v].points.front());
    const double facing = dot(directions[v], normalized(at.gradient));
    const double detour = columns[v].length.back() / (thickness_per_radius * at.radius);
    share[v] = (1.0 - at.narrowed) *
               std::max(between(facing, kLeads, kMisleads), between(detour, kStraightWay, kDetour));
  });
  return share;
}

/// The radius that the wall's thickness goes by where lines do not lead.
std::vector<double> own_radii(const TriangleMesh& lumen, const std::vector<Vec3>& directions,
                              const HealthyVessel& healthy) {
  std::vector<Vec3> inward;
  for (const Vec3& direction : directions) inward.push_back(-1.0 * direction);
  std::vector<double> radii, reach;
  for (const Vec3& point : lumen.vertices) {
    radii.push_back(healthy.evaluate(point).radius);
    reach.push_back(radii.back() / kWidthShare);
  }
  const auto widths = air_mesh::distances_ahead(lumen, inward, reach, air_mesh::Side::inside);
  for (std::size_t v = 0; v < radii.size(); ++v)
    radii[v] = std::min(radii[v], kWidthShare * widths[v]);
  return radii;
}

/// Draws a column towards the straight way of a length, by a share.
void straighten(double share, const Vec3& direction, double own_length, WallColumn& column) {
  if (share <= 0.0) return;
  const Vec3 start = column.points.front();
  WallColumn mixed;
  constexpr int kPoints = 32;
  const double wall = (1.0 - share) * column.thickness + share * own_length;
  const double plaque = (1.0 - share) * column.plaque;
  for (int i = 0; i <= kPoints; ++i) {
    const double part = double(i) / kPoints;
    const Vec3 led = place_at(column, part * (column.plaque + column.thickness));
    const Vec3 point = (1.0 - share) * led + share * (start + part * own_length * direction);
    mixed.length.push_back(part * (plaque + wall));
    mixed.distance.push_back(mixed.length.back() - plaque);
    mixed.points.push_back(point);
  }
  mixed.plaque = plaque;
  mixed.thickness = wall;
  mixed.missing = (1.0 - share) * column.missing;
  column = std::move(mixed);
}

/// Shares of the ways that end halfway to the next vessel, changing evenly along the surface.
void leave_room(const TriangleMesh& lumen, const std::vector<std::vector<int>>& neighbors,
                std::vector<WallColumn>& columns) {
  std::vector<Vec3> directions;
  std::vector<double> reach;
  for (const WallColumn& column : columns) {
    const Vec3 way = column.points.back() - column.points.front();
    directions.push_back(norm(way) > 0.0 ? normalized(way) : Vec3{1.0, 0.0, 0.0});
    reach.push_back(norm(way) / kRoomShare);
  }
  const auto ahead = air_mesh::distances_ahead(lumen, directions, reach, air_mesh::Side::outside);
  for (std::size_t v = 0; v < columns.size(); ++v)
    if (ahead[v] < reach[v]) columns[v].room = ahead[v] / reach[v];
  for (int pass = 0; pass < kSmoothings; ++pass) {
    const std::vector<WallColumn>& before = columns;
    std::vector<double> room(columns.size());
    for (std::size_t v = 0; v < columns.size(); ++v) {
      double sum = 0.0;
      for (const int n : neighbors[v]) sum += before[std::size_t(n)].room;
      const double mean = neighbors[v].empty() ? 1.0 : sum / double(neighbors[v].size());
      room[v] = std::min(before[v].room, 0.5 * (before[v].room + mean));
    }
    for (std::size_t v = 0; v < columns.size(); ++v) columns[v].room = room[v];
  }
}

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
  const auto share =
      smoothed(misled(columns, directions, healthy, thickness_per_radius), neighbors);
  const auto radii = smoothed(own_radii(lumen, directions, healthy), neighbors);
  for (std::size_t v = 0; v < columns.size(); ++v)
    straighten(share[v], directions[v], thickness_per_radius * radii[v], columns[v]);
  leave_room(lumen, neighbors, columns);
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

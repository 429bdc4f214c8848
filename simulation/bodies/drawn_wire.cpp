#include "simulation/bodies/drawn_wire.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.hpp"

namespace angio::simulation::detail {
namespace {

// How far along a polyline its nearest point to p lies.
double place_along(const std::vector<Vec3>& line, const std::vector<double>& length,
                   const Vec3& p) {
  double nearest = std::numeric_limits<double>::max(), place = 0.0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec3 along = line[i + 1] - line[i];
    const double t =
        std::clamp(dot(p - line[i], along) / std::max(norm_squared(along), 1e-300), 0.0, 1.0);
    const double d = distance(p, line[i] + t * along);
    if (d >= nearest) continue;
    nearest = d;
    place = length[i] + t * norm(along);
  }
  return place;
}

// Does the closed surface go around the point? By the sum of its triangles' solid angles.
//
// Source: Van Oosterom, Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125
bool encloses(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x, const Vec3& p) {
  double sum = 0.0;
  for (const Triangle& t : triangles) {
    const Vec3 a = x[std::size_t(t[0])] - p, b = x[std::size_t(t[1])] - p,
               c = x[std::size_t(t[2])] - p;
    sum += 2.0 * std::atan2(dot(a, cross(b, c)), norm(a) * norm(b) * norm(c) + dot(a, b) * norm(c) +
                                                     dot(b, c) * norm(a) + dot(c, a) * norm(b));
  }
  return sum > 2.0 * units::kPi;
}

// The way from p along a direction to the triangle; infinite where it is missed.
double way_to(const Vec3& p, const Vec3& direction, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, h = cross(direction, ac);
  const double det = dot(ab, h);
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (det == 0.0) return kNone;
  const double u = dot(p - a, h) / det;
  const Vec3 q = cross(p - a, ab);
  const double v = dot(direction, q) / det, t = dot(ac, q) / det;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 ? t : kNone;
}

// Half-way through the surface from a vertex inwards.
Vec3 middle_behind(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x, int vertex) {
  const Vec3& p = x[std::size_t(vertex)];
  Vec3 normal;
  for (const Triangle& t : triangles)
    if (std::find(t.begin(), t.end(), vertex) != t.end())
      normal += cross(x[std::size_t(t[1])] - x[std::size_t(t[0])],
                      x[std::size_t(t[2])] - x[std::size_t(t[0])]);
  if (!(norm(normal) > 0.0)) return p;
  const Vec3 inwards = -normalized(normal);
  double way = std::numeric_limits<double>::infinity();
  for (const Triangle& t : triangles)
    if (std::find(t.begin(), t.end(), vertex) == t.end())
      way = std::min(way, way_to(p, inwards, x[std::size_t(t[0])], x[std::size_t(t[1])],
                                 x[std::size_t(t[2])]));
  return std::isfinite(way) ? p + 0.5 * way * inwards : p;
}

}  // namespace

DrawnWire::DrawnWire(const SimulationModel& model) : triangles_(model.balloon.triangles) {
  const std::vector<Vec3>& line = model.guidewire;
  if (line.size() < 2) return;
  const std::vector<Vec3>& x = model.balloon.vertices;
  std::vector<double> length{0.0};
  for (std::size_t i = 1; i < line.size(); ++i)
    length.push_back(length.back() + distance(line[i - 1], line[i]));
  std::vector<double> place;
  for (const Vec3& p : x) place.push_back(place_along(line, length, p));
  const double reach = length.back() / double(line.size() - 1);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto from_node = [&](const Vec3& p, const Vec3& q) {
      return distance(p, line[i]) < distance(q, line[i]);
    };
    const int nearest = int(std::min_element(x.begin(), x.end(), from_node) - x.begin());
    std::vector<Share>& around = around_.emplace_back();
    const bool is_end = i == 0 || i + 1 == line.size();
    double sum = 0.0;
    for (std::size_t v = 0; v < x.size() && !is_end; ++v) {
      const double weight = 1.0 - std::abs(place[v] - length[i]) / reach;
      if (weight > 0.0) around.push_back({int(v), weight});
      sum += std::max(weight, 0.0);
    }
    if (around.empty()) around.push_back({nearest, sum = 1.0});
    for (Share& share : around) share.weight /= sum;
  }
}

std::vector<Vec3> DrawnWire::nodes(const std::vector<Vec3>& balloon) const {
  std::vector<Vec3> result;
  for (const std::vector<Share>& around : around_) {
    Vec3 middle;
    for (const Share& share : around) middle += share.weight * balloon[std::size_t(share.vertex)];
    if (around.size() > 1 && !encloses(triangles_, balloon, middle)) {
      const auto nearer = [&](const Share& a, const Share& b) {
        return distance(balloon[std::size_t(a.vertex)], middle) <
               distance(balloon[std::size_t(b.vertex)], middle);
      };
      middle = middle_behind(triangles_, balloon,
                             std::min_element(around.begin(), around.end(), nearer)->vertex);
    }
    result.push_back(middle);
  }
  return result;
}

}  // namespace angio::simulation::detail

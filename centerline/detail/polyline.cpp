#include "centerline/detail/polyline.hpp"

#include <algorithm>
#include <cmath>

#include "core/centerline.hpp"

namespace angio::centerline {
namespace {

/// The point of a polyline at arc length `at`.
Vec3 point_at(const std::vector<Vec3>& points, const std::vector<double>& s, double at) {
  const auto above = std::upper_bound(s.begin(), s.end(), at);
  const auto b =
      std::size_t(std::clamp<std::ptrdiff_t>(above - s.begin(), 1, std::ptrdiff_t(s.size()) - 1));
  const double length = s[b] - s[b - 1];
  const double t = length > 0.0 ? std::clamp((at - s[b - 1]) / length, 0.0, 1.0) : 0.0;
  return (1.0 - t) * points[b - 1] + t * points[b];
}

Vec3 catmull_rom(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double t) {
  const double t2 = t * t, t3 = t2 * t;
  return 0.5 * ((2.0 * b) + t * (c - a) + t2 * (2.0 * a - 5.0 * b + 4.0 * c - d) +
                t3 * (3.0 * b - a - 3.0 * c + d));
}

}  // namespace

void Polyline::erase(std::size_t first, std::size_t last) {
  const auto f = std::ptrdiff_t(first), l = std::ptrdiff_t(last);
  points.erase(points.begin() + f, points.begin() + l);
  radius.erase(radius.begin() + f, radius.begin() + l);
  extent.erase(extent.begin() + f, extent.begin() + l);
}

void reverse(Polyline& line) {
  std::reverse(line.points.begin(), line.points.end());
  std::reverse(line.radius.begin(), line.radius.end());
  std::reverse(line.extent.begin(), line.extent.end());
}

double direction_reach(const Polyline& line, std::size_t i) {
  return line.extent[i] + 1.5 * std::max(line.extent[i] - line.radius[i], 0.0);
}

Vec3 tangent_at(const Polyline& line, const std::vector<double>& s, std::size_t i, double reach) {
  // The same reach to both sides, or the tangent of a bend would turn near the ends of the line.
  const double room = std::min(s[i], s.back() - s[i]);
  const double least = i + 1 < s.size() ? s[i + 1] - s[i] : s[i] - s[i - 1];
  const double each = std::max(std::min(reach, room), std::min(least, 0.5 * reach));
  return normalized(point_at(line.points, s, s[i] + each) - point_at(line.points, s, s[i] - each));
}

Vec3 end_tangent(const Polyline& line, double reach) {
  const std::size_t last = line.points.size() - 1;
  std::size_t from = last;
  while (from > 0 && distance(line.points[from], line.points[last]) < reach) --from;
  return normalized(line.points[last] - line.points[from]);
}

bool inside_tube(const std::vector<Vec3>& points, const std::vector<double>& radius,
                 std::size_t from, const Vec3& point) {
  for (std::size_t m = from; m + 1 < points.size(); ++m) {
    const Vec3 along = points[m + 1] - points[m];
    const double squared = norm_squared(along);
    // Twice the sum of two squares is no less than the square of the sum.
    const double reach = std::max(radius[m], radius[m + 1]);
    if (norm_squared(point - points[m]) > 2.0 * (squared + reach * reach)) continue;
    const double t =
        squared > 0.0 ? std::clamp(dot(point - points[m], along) / squared, 0.0, 1.0) : 0.0;
    const double r = (1.0 - t) * radius[m] + t * radius[m + 1];
    if (norm_squared(point - (points[m] + t * along)) < r * r) return true;
  }
  return false;
}

void smooth(Polyline& line, std::size_t fixed, int passes) {
  const std::size_t first = std::max<std::size_t>(fixed, 1);
  for (int pass = 0; pass < passes; ++pass) {
    const Polyline old = line;
    for (std::size_t i = first; i + 1 < line.points.size(); ++i) {
      line.points[i] = 0.5 * old.points[i] + 0.25 * (old.points[i - 1] + old.points[i + 1]);
      line.radius[i] = 0.5 * old.radius[i] + 0.25 * (old.radius[i - 1] + old.radius[i + 1]);
      line.extent[i] = 0.5 * old.extent[i] + 0.25 * (old.extent[i - 1] + old.extent[i + 1]);
    }
  }
}

void smooth_widths(Polyline& line, std::size_t fixed, int passes) {
  const std::vector<Vec3> points = line.points;
  smooth(line, fixed, passes);
  line.points = points;
}

void resample(Polyline& line, std::size_t fixed, const std::function<double(double)>& step) {
  const std::size_t anchor = fixed > 0 ? fixed - 1 : 0;
  const std::vector<double> s = arc_length(line.points);
  // Steps follow the radius; a last pass stretches them evenly so that they end at the end.
  std::vector<double> at{s[anchor]};
  std::size_t segment = anchor;
  while (at.back() < s.back()) {
    while (segment + 2 < s.size() && s[segment + 1] <= at.back()) ++segment;
    at.push_back(at.back() + step(line.radius[segment]));
  }
  if (at.size() > 2 && at.back() - s.back() > 0.5 * (at.back() - at[at.size() - 2])) at.pop_back();
  const double stretch = (s.back() - s[anchor]) / (at.back() - s[anchor]);
  Polyline result = line;
  result.resize(anchor + 1);
  segment = anchor;
  for (std::size_t k = 1; k + 1 < at.size(); ++k) {
    const double target = s[anchor] + stretch * (at[k] - s[anchor]);
    while (segment + 2 < s.size() && s[segment + 1] <= target) ++segment;
    const double length = s[segment + 1] - s[segment];
    const double t = length > 0.0 ? (target - s[segment]) / length : 0.0;
    const Vec3& b = line.points[segment];
    const Vec3& c = line.points[segment + 1];
    const Vec3 a = segment > 0 ? line.points[segment - 1] : 2.0 * b - c;
    const Vec3 d = segment + 2 < s.size() ? line.points[segment + 2] : 2.0 * c - b;
    result.push_back(catmull_rom(a, b, c, d, t),
                     (1.0 - t) * line.radius[segment] + t * line.radius[segment + 1]);
    result.extent.back() = (1.0 - t) * line.extent[segment] + t * line.extent[segment + 1];
  }
  result.push_back(line.points.back(), line.radius.back());
  result.extent.back() = line.extent.back();
  line = std::move(result);
}

std::vector<Vec3> bridge(const Vec3& from, const Vec3& from_tangent, const Vec3& to,
                         const Vec3& to_tangent, int count) {
  const double chord = distance(from, to);
  std::vector<Vec3> points;
  for (int i = 1; i <= count; ++i) {
    const double t = double(i) / (count + 1);
    const double t2 = t * t, t3 = t2 * t;
    points.push_back((2.0 * t3 - 3.0 * t2 + 1.0) * from +
                     (t3 - 2.0 * t2 + t) * chord * from_tangent + (-2.0 * t3 + 3.0 * t2) * to +
                     (t3 - t2) * chord * to_tangent);
  }
  return points;
}

}  // namespace angio::centerline

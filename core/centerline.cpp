#include "core/centerline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace angio {

const std::vector<double>& measured_radius(const CenterlinePath& path) {
  return path.tube_radius.empty() ? path.inscribed_radius : path.tube_radius;
}

CenterlineSample sample(const CenterlinePath& path, double abscissa) {
  const auto above = std::upper_bound(path.abscissa.begin(), path.abscissa.end(), abscissa);
  const auto last = std::ptrdiff_t(path.points.size()) - 1;
  const auto b = std::size_t(std::clamp<std::ptrdiff_t>(above - path.abscissa.begin(), 1, last));
  const std::size_t a = b - 1;
  const double length = path.abscissa[b] - path.abscissa[a];
  const double t =
      length > 0.0 ? std::clamp((abscissa - path.abscissa[a]) / length, 0.0, 1.0) : 0.0;
  const auto between = [&](const std::vector<double>& v) {
    return v.empty() ? 0.0 : (1.0 - t) * v[a] + t * v[b];
  };
  // A central difference over neighbouring points keeps the tangent from jumping at each point.
  const std::size_t before = a > 0 ? a - 1 : a;
  const std::size_t after = b < std::size_t(last) ? b + 1 : b;
  const Vec3 tangent_a = path.points[b] - path.points[before];
  const Vec3 tangent_b = path.points[after] - path.points[a];
  return {(1.0 - t) * path.points[a] + t * path.points[b],
          normalized((1.0 - t) * normalized(tangent_a) + t * normalized(tangent_b)),
          between(path.inscribed_radius), between(path.equivalent_radius)};
}

double project(const CenterlinePath& path, const Vec3& point) {
  double best = std::numeric_limits<double>::infinity();
  double abscissa = 0.0;
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const Vec3 along = path.points[i + 1] - path.points[i];
    const double squared = norm_squared(along);
    const double t =
        squared > 0.0 ? std::clamp(dot(point - path.points[i], along) / squared, 0.0, 1.0) : 0.0;
    const double d = norm_squared(point - (path.points[i] + t * along));
    if (d < best) {
      best = d;
      abscissa = path.abscissa[i] + t * (path.abscissa[i + 1] - path.abscissa[i]);
    }
  }
  return abscissa;
}

double radius_at_end(const CenterlinePath& path, PathEnd end) {
  constexpr double kReach = 1.7;  // 1 at a flat end; caps slant by up to 54 degrees
  const bool is_first = end == PathEnd::inlet;
  const double at = is_first ? path.abscissa.front() : path.abscissa.back();
  double radius = is_first ? path.inscribed_radius.front() : path.inscribed_radius.back();
  for (std::size_t i = 0; i < path.points.size(); ++i)
    if (std::abs(at - path.abscissa[i]) <= kReach * path.inscribed_radius[i])
      radius = std::max(radius, path.inscribed_radius[i]);
  return radius;
}

std::vector<double> arc_length(const std::vector<Vec3>& points) {
  std::vector<double> lengths(points.size(), 0.0);
  for (std::size_t i = 1; i < points.size(); ++i)
    lengths[i] = lengths[i - 1] + distance(points[i], points[i - 1]);
  return lengths;
}

}  // namespace angio

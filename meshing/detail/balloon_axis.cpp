#include "meshing/detail/balloon_axis.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace angio::meshing::detail {
namespace {

constexpr double kGapShare = 0.15;  // of the axis's distance from the wall
constexpr double kLeastGap = 0.02;  // [mm]
constexpr double kBendLimit = 0.6;  // ring radius / radius of curvature

/// A place on the path; beyond its ends it goes on straight.
Vec3 extended_point(const CenterlinePath& path, double abscissa) {
  const double first = path.abscissa.front();
  const double last = path.abscissa.back();
  const CenterlineSample at = sample(path, abscissa);
  const double beyond = abscissa < first ? abscissa - first : std::max(0.0, abscissa - last);
  return at.point + beyond * at.tangent;
}

/// The path around a place, smoothed by a Gaussian; longer than asked for on both sides.
struct SmoothedPath {
  std::vector<Vec3> points;
  std::size_t middle = 0;
  double step = 0.0;  ///< between points, about [mm]
};
SmoothedPath smooth_path(const CenterlinePath& path, double middle, double half_length,
                         double sigma) {
  SmoothedPath result;
  result.step = std::min(0.1, half_length / 100.0);
  const double step = result.step;
  const int side = int(std::ceil((1.15 * half_length + 2.0 * step) / step));
  const int kernel = sigma > 0.0 ? int(std::ceil(3.0 * sigma / step)) : 0;
  std::vector<Vec3> raw;
  for (int i = -side - kernel; i <= side + kernel; ++i)
    raw.push_back(extended_point(path, middle + i * step));
  for (int i = 0; i <= 2 * side; ++i) {
    Vec3 sum;
    double weight_sum = 0.0;
    for (int k = 0; k <= 2 * kernel; ++k) {
      const double u = sigma > 0.0 ? (k - kernel) * step / sigma : 0.0;
      const double weight = std::exp(-0.5 * u * u);
      sum += weight * raw[std::size_t(i + k)];
      weight_sum += weight;
    }
    result.points.push_back(sum / weight_sum);
  }
  result.middle = std::size_t(side);
  return result;
}

/// Pushes an axis away from the wall where there is less room than wanted, as an elastic band.
void centre_in_lumen(SmoothedPath& axis, const SurfaceTarget& wall, double wanted_room) {
  constexpr int kIterations = 60;
  constexpr int kSmoothings = 4;  // each, so that the band stays smooth
  std::vector<Vec3>& x = axis.points;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    std::vector<Vec3> pushed = x;
    bool moved = false;
    for (std::size_t i = 1; i + 1 < x.size(); ++i) {
      const TargetSample at = wall.evaluate(x[i]);
      const double lack = wanted_room + at.signed_distance;
      if (lack <= 0.0) continue;
      const Vec3 tangent = normalized(x[i + 1] - x[i - 1]);
      const Vec3 away = -at.normal + dot(at.normal, tangent) * tangent;
      pushed[i] += std::min(0.5 * lack, axis.step) * away;
      moved = true;
    }
    if (!moved) return;
    for (int pass = 0; pass < kSmoothings; ++pass) {
      const std::vector<Vec3> before = pushed;
      for (std::size_t i = 1; i + 1 < x.size(); ++i)
        pushed[i] = 0.5 * before[i] + 0.25 * (before[i - 1] + before[i + 1]);
    }
    x = std::move(pushed);
  }
}

/// The stretch of an axis within half a length on both sides of its middle, in equal steps.
FramedAxis cut_to_length(const SmoothedPath& axis, double half_length) {
  const std::vector<double> length = arc_length(axis.points);
  const double centre = length[axis.middle];
  const auto point_at = [&](double s) {
    const auto above = std::upper_bound(length.begin(), length.end(), s);
    const auto b = std::size_t(
        std::clamp<std::ptrdiff_t>(above - length.begin(), 1, std::ptrdiff_t(length.size()) - 1));
    const double t = (s - length[b - 1]) / std::max(length[b] - length[b - 1], 1e-12);
    return axis.points[b - 1] + t * (axis.points[b] - axis.points[b - 1]);
  };
  FramedAxis cut;
  const int count = std::max(200, int(std::ceil(2.0 * half_length / axis.step)));
  for (int i = 0; i <= count; ++i)
    cut.points.push_back(point_at(centre - half_length + 2.0 * half_length * i / count));
  return cut;
}

/// Rotation-minimising frames by double reflection.
///
/// Source: Wang, Juettler, Zheng, Liu, "Computation of rotation minimizing frames", ACM TOG 27
/// (2008), Table I
void add_frames(FramedAxis& axis) {
  const std::size_t count = axis.points.size();
  axis.abscissa = arc_length(axis.points);
  for (std::size_t i = 0; i < count; ++i)
    axis.tangents.push_back(
        normalized(axis.points[std::min(i + 1, count - 1)] - axis.points[i > 0 ? i - 1 : 0]));
  axis.normals.push_back(any_perpendicular(axis.tangents.front()));
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const Vec3 v1 = axis.points[i + 1] - axis.points[i];
    const double c1 = norm_squared(v1);
    const Vec3 reflected_normal = axis.normals[i] - (2.0 / c1) * dot(v1, axis.normals[i]) * v1;
    const Vec3 reflected_tangent = axis.tangents[i] - (2.0 / c1) * dot(v1, axis.tangents[i]) * v1;
    const Vec3 v2 = axis.tangents[i + 1] - reflected_tangent;
    const double c2 = norm_squared(v2);
    Vec3 next = reflected_normal;
    if (c2 > 0.0) next -= (2.0 / c2) * dot(v2, reflected_normal) * v2;
    next -= dot(next, axis.tangents[i + 1]) * axis.tangents[i + 1];
    axis.normals.push_back(normalized(next));
  }
}

void add_fitting_radii(FramedAxis& axis, const SurfaceTarget& wall) {
  for (std::size_t i = 0; i < axis.points.size(); ++i) {
    const double room = -wall.evaluate(axis.points[i]).signed_distance;
    double radius = room - std::max(kGapShare * room, kLeastGap);
    // Curvature from tangents a few points apart.
    const std::size_t a = i > 2 ? i - 2 : 0;
    const std::size_t b = std::min(i + 2, axis.points.size() - 1);
    const double turn = norm(axis.tangents[b] - axis.tangents[a]);
    const double curvature = turn / std::max(axis.abscissa[b] - axis.abscissa[a], 1e-12);
    if (curvature * radius > kBendLimit) radius = kBendLimit / curvature;
    axis.fitting_radius.push_back(radius);
  }
}

}  // namespace

double FramedAxis::narrowest() const {
  return *std::min_element(fitting_radius.begin(), fitting_radius.end());
}

AxisFrame frame_at(const FramedAxis& axis, double abscissa) {
  const double u = std::clamp(abscissa / axis.length(), 0.0, 1.0) * double(axis.points.size() - 1);
  const std::size_t a = std::min(std::size_t(u), axis.points.size() - 2);
  const double t = u - double(a);
  const Vec3 tangent = normalized((1.0 - t) * axis.tangents[a] + t * axis.tangents[a + 1]);
  Vec3 normal = (1.0 - t) * axis.normals[a] + t * axis.normals[a + 1];
  normal = normalized(normal - dot(normal, tangent) * tangent);
  return {(1.0 - t) * axis.points[a] + t * axis.points[a + 1], tangent, normal};
}

Vec3 smoothed_point(const CenterlinePath& path, double abscissa, double sigma) {
  constexpr int kSide = 24;  // three deviations in eighths
  Vec3 sum;
  double weight_sum = 0.0;
  for (int k = -kSide; k <= kSide; ++k) {
    const double u = k / 8.0, weight = std::exp(-0.5 * u * u);
    sum += weight * extended_point(path, abscissa + u * sigma);
    weight_sum += weight;
  }
  return sum / weight_sum;
}

double room_for(double radius) { return std::max(radius / (1.0 - kGapShare), radius + kLeastGap); }

FramedAxis fit_axis(const AxisWish& wish, const CenterlinePath& path, const SurfaceTarget& wall) {
  const double half_length = 0.5 * wish.length;
  const double wanted_room = room_for(wish.radius);
  std::optional<FramedAxis> best;
  for (const bool centred : {false, true})
    for (const double share : {1.0, 2.0, 4.0, 0.5}) {
      SmoothedPath smoothed =
          smooth_path(path, wish.middle_abscissa, half_length, share * wish.smoothing);
      if (centred) centre_in_lumen(smoothed, wall, wanted_room);
      FramedAxis candidate = cut_to_length(smoothed, half_length);
      add_frames(candidate);
      add_fitting_radii(candidate, wall);
      if (!best || candidate.narrowest() > 1.05 * best->narrowest()) best = candidate;
      if (candidate.narrowest() >= wish.radius) return candidate;
    }
  return *std::move(best);
}

}  // namespace angio::meshing::detail

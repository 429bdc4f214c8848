#include "meshing/detail/balloon_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include "core/error.hpp"

namespace angio::meshing::detail {
namespace {

constexpr double kGapShare = 0.15;          // of the axis's distance from the wall
constexpr double kLeastGap = 0.02;          // [mm]
constexpr double kLeastStartRadius = 0.10;  // [mm] thinner than any guidewire (0.18 mm)
constexpr double kRingSlope = 0.4;          // by which neighbouring rings may differ
constexpr double kBendLimit = 0.6;          // ring radius / radius of curvature

std::string two_digits(double value) {
  const std::string text = std::to_string(value + 0.005);
  return text.substr(0, text.find('.') + 3);
}

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

struct Frame {
  Vec3 point, tangent, normal;
};
Frame frame_at(const FramedAxis& axis, double s) {
  const double last = axis.abscissa.back();
  const double u = std::clamp(s / last, 0.0, 1.0) * double(axis.points.size() - 1);
  const std::size_t a = std::min(std::size_t(u), axis.points.size() - 2);
  const double t = u - double(a);
  const Vec3 tangent = normalized((1.0 - t) * axis.tangents[a] + t * axis.tangents[a + 1]);
  Vec3 normal = (1.0 - t) * axis.normals[a] + t * axis.normals[a + 1];
  normal = normalized(normal - dot(normal, tangent) * tangent);
  return {(1.0 - t) * axis.points[a] + t * axis.points[a + 1], tangent, normal};
}

/// Largest radius that fits at each point of the axis; negative where the axis leaves the lumen.
std::vector<double> fitting_radii(const FramedAxis& axis) {
  std::vector<double> radii;
  for (std::size_t i = 0; i < axis.points.size(); ++i) {
    const double room = axis.wall_distance[i];
    double radius = room - std::max(kGapShare * room, kLeastGap);
    // Curvature from tangents a few points apart.
    const std::size_t a = i > 2 ? i - 2 : 0;
    const std::size_t b = std::min(i + 2, axis.points.size() - 1);
    const double turn = norm(axis.tangents[b] - axis.tangents[a]);
    const double curvature = turn / std::max(axis.abscissa[b] - axis.abscissa[a], 1e-12);
    if (curvature * radius > kBendLimit) radius = kBendLimit / curvature;
    radii.push_back(radius);
  }
  return radii;
}

/// Ring radii of the start shape; `narrowest` is the least that fits anywhere.
struct StartRings {
  std::vector<double> radius;
  double narrowest = 0.0;
};
StartRings start_rings(const BalloonPlan& plan, const CapsuleRings& rest, const FramedAxis& axis) {
  const std::vector<double> fits = fitting_radii(axis);
  const double scale = axis.abscissa.back() / plan.total_length();
  StartRings start;
  start.narrowest = *std::min_element(fits.begin(), fits.end());
  const std::size_t count = rest.position.size();
  for (std::size_t i = 0; i < count; ++i) {
    // The membrane between the neighbouring rings must fit as well.
    const double from = i > 0 ? rest.position[i - 1] * scale : 0.0;
    const double to = i + 1 < count ? rest.position[i + 1] * scale : axis.abscissa.back();
    double radius = std::min(rest.radius[i], plan.start_radius);
    for (std::size_t p = 0; p < fits.size(); ++p)
      if (axis.abscissa[p] >= from - 1e-9 && axis.abscissa[p] <= to + 1e-9)
        radius = std::min(radius, fits[p]);
    start.radius.push_back(radius);
  }
  for (std::size_t i = 1; i < count; ++i)
    start.radius[i] =
        std::min(start.radius[i],
                 start.radius[i - 1] + kRingSlope * (rest.position[i] - rest.position[i - 1]));
  for (std::size_t i = count - 1; i > 0; --i)
    start.radius[i - 1] =
        std::min(start.radius[i - 1],
                 start.radius[i] + kRingSlope * (rest.position[i] - rest.position[i - 1]));
  return start;
}

struct FittedAxis {
  FramedAxis axis;
  StartRings rings;
};
/// The first axis along which the rings can be as wide as wanted; else the roomiest.
FittedAxis fit_axis(const BalloonPlan& plan, const CapsuleRings& rest, const CenterlinePath& path,
                    const SurfaceTarget& wall) {
  const double half_length = 0.5 * plan.total_length();
  const double wanted_room =
      std::max(plan.start_radius / (1.0 - kGapShare), plan.start_radius + kLeastGap);
  std::optional<FittedAxis> best;
  for (const bool centred : {false, true})
    for (const double share : {0.5, 1.0, 2.0, 0.25}) {
      SmoothedPath smoothed =
          smooth_path(path, plan.middle_abscissa, half_length, share * plan.nominal_radius);
      if (centred) centre_in_lumen(smoothed, wall, wanted_room);
      FittedAxis candidate;
      candidate.axis = cut_to_length(smoothed, half_length);
      add_frames(candidate.axis);
      for (const Vec3& p : candidate.axis.points)
        candidate.axis.wall_distance.push_back(-wall.evaluate(p).signed_distance);
      candidate.rings = start_rings(plan, rest, candidate.axis);
      const double narrowest = candidate.rings.narrowest;
      if (!best || narrowest > 1.05 * best->rings.narrowest) best = std::move(candidate);
      if (narrowest >= plan.start_radius) return *std::move(best);
    }
  return *std::move(best);
}

}  // namespace

CapsuleRings capsule_rings(const BalloonPlan& plan) {
  const double r = plan.nominal_radius;
  const double meridian = plan.cylinder_length + std::numbers::pi * r;
  const double angle = 2.0 * std::numbers::pi / plan.ring_vertex_count;
  const double polygon = std::sqrt(angle / std::sin(angle));
  const double quarter = 0.5 * std::numbers::pi * r;
  CapsuleRings rings;
  for (int i = 0; i < plan.ring_count; ++i) {
    const double m = meridian * (i + 1) / (plan.ring_count + 1);
    if (m < quarter) {
      rings.position.push_back(r * (1.0 - std::cos(m / r)));
      rings.radius.push_back(polygon * r * std::sin(m / r));
    } else if (m <= meridian - quarter) {
      rings.position.push_back(r + m - quarter);
      rings.radius.push_back(polygon * r);
    } else {
      const double back = (meridian - m) / r;
      rings.position.push_back(plan.total_length() - r * (1.0 - std::cos(back)));
      rings.radius.push_back(polygon * r * std::sin(back));
    }
  }
  return rings;
}

std::vector<Triangle> capsule_triangles(int ring_count, int ring_vertex_count) {
  std::vector<Triangle> triangles;
  const int n = ring_vertex_count;
  const int pole = ring_count * n;
  for (int k = 0; k < n; ++k) triangles.push_back({pole, (k + 1) % n, k});
  for (int i = 0; i + 1 < ring_count; ++i)
    for (int k = 0; k < n; ++k) {
      const int a = i * n + k;
      const int b = i * n + (k + 1) % n;
      const int c = b + n;
      const int d = a + n;
      if ((i + k) % 2 == 0) {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
      } else {
        triangles.push_back({a, b, d});
        triangles.push_back({b, c, d});
      }
    }
  const int last = (ring_count - 1) * n;
  for (int k = 0; k < n; ++k) triangles.push_back({pole + 1, last + k, last + (k + 1) % n});
  return triangles;
}

Balloon shape_balloon(const BalloonPlan& plan, const CenterlinePath& path,
                      const SurfaceTarget& wall) {
  const CapsuleRings rest = capsule_rings(plan);
  const FittedAxis fitted = fit_axis(plan, rest, path, wall);
  if (fitted.rings.narrowest < kLeastStartRadius)
    throw InputError(
        "the balloon does not fit through the lumen (at its narrowest place a radius of " +
        two_digits(std::max(0.0, fitted.rings.narrowest)) + " mm is free, " +
        two_digits(kLeastStartRadius) +
        " mm is needed). Choose another place or a shorter balloon (meshing.length_mm), or check "
        "the segmentation there");
  Balloon balloon;
  balloon.nominal_diameter_mm = 2.0 * plan.nominal_radius;
  balloon.length_mm = plan.cylinder_length;
  balloon.start_diameter_mm =
      2.0 * *std::max_element(fitted.rings.radius.begin(), fitted.rings.radius.end());
  balloon.start.triangles = capsule_triangles(plan.ring_count, plan.ring_vertex_count);
  for (std::size_t i = 0; i < rest.position.size(); ++i) {
    const Frame frame =
        frame_at(fitted.axis, rest.position[i] * fitted.axis.abscissa.back() / plan.total_length());
    const Vec3 binormal = cross(frame.tangent, frame.normal);
    for (int k = 0; k < plan.ring_vertex_count; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / plan.ring_vertex_count;
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      balloon.rest.push_back({rest.radius[i] * c, rest.radius[i] * s, rest.position[i]});
      balloon.start.vertices.push_back(frame.point +
                                       fitted.rings.radius[i] * (c * frame.normal + s * binormal));
    }
  }
  balloon.rest.push_back({0.0, 0.0, 0.0});
  balloon.rest.push_back({0.0, 0.0, plan.total_length()});
  balloon.start.vertices.push_back(fitted.axis.points.front());
  balloon.start.vertices.push_back(fitted.axis.points.back());
  for (int i = 0; i < plan.guidewire_node_count; ++i)
    balloon.guidewire.push_back(
        frame_at(fitted.axis, fitted.axis.abscissa.back() * i / (plan.guidewire_node_count - 1))
            .point);
  return balloon;
}

void shrink_start(Balloon& balloon, const BalloonPlan& plan, double factor) {
  const auto n = std::size_t(plan.ring_vertex_count);
  for (std::size_t i = 0; i < std::size_t(plan.ring_count); ++i) {
    Vec3 centre;
    for (std::size_t k = 0; k < n; ++k)
      centre += (1.0 / double(n)) * balloon.start.vertices[i * n + k];
    for (std::size_t k = 0; k < n; ++k) {
      Vec3& x = balloon.start.vertices[i * n + k];
      x = centre + factor * (x - centre);
    }
  }
  balloon.start_diameter_mm *= factor;
}

}  // namespace angio::meshing::detail

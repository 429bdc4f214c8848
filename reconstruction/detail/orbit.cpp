#include "reconstruction/detail/orbit.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/units.hpp"

namespace angio::reconstruction::detail {
namespace {

using angiogram::ConeBeamFrame;
constexpr double kDegree = units::kPi / 180.0;
constexpr double kNearAnAxis = 2.0 * kDegree;
constexpr double kLeastArc = 40.0 * kDegree;
constexpr double kStillMm = 1.0;
constexpr std::size_t kLeastFrames = 3;

Eigen::Vector3d eigen_from(const Vec3& v) { return {v.x, v.y, v.z}; }
Vec3 vec_from(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Vec3 mean_source(const std::vector<ConeBeamFrame>& frames) {
  Vec3 sum;
  for (const ConeBeamFrame& frame : frames) sum += frame.source;
  return sum / double(frames.size());
}

/// The normal of the plane that the sources lie nearest to.
Vec3 normal_of_sources(const std::vector<ConeBeamFrame>& frames) {
  const Eigen::Vector3d middle = eigen_from(mean_source(frames));
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const ConeBeamFrame& frame : frames) {
    const Eigen::Vector3d d = eigen_from(frame.source) - middle;
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  if (std::sqrt(solver.eigenvalues()[2] / double(frames.size())) < kStillMm)
    throw InputError(
        "the run's source stands still (static frames, of one angle). Give a rotational run, or "
        "the volume that the workstation made");
  return vec_from(solver.eigenvectors().col(0));
}

/// The axis, upward; one of the patient's where it is meant to be one.
Vec3 axis_of(const std::vector<ConeBeamFrame>& frames) {
  Vec3 axis = normal_of_sources(frames);
  for (int k = 0; k < 3; ++k)
    if (std::abs(axis[k]) > std::cos(kNearAnAxis)) {
      Vec3 exact;
      exact[k] = 1.0;
      return exact;
    }
  const int largest = std::abs(axis.z) >= 0.5 ? 2 : std::abs(axis.y) >= std::abs(axis.x) ? 1 : 0;
  return axis[largest] < 0.0 ? -axis : axis;
}

/// The middle of the circle across the axis, by least squares of x^2 + y^2 - a x - b y - c.
Vec3 circle_middle(const std::vector<ConeBeamFrame>& frames, const Orbit& orbit) {
  const Vec3 from = mean_source(frames);
  Eigen::MatrixXd terms(Eigen::Index(frames.size()), 3);
  Eigen::VectorXd squares(Eigen::Index(frames.size()));
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const Vec3 d = frames[f].source - from;
    const double x = dot(d, orbit.first_direction), y = dot(d, orbit.second_direction);
    terms.row(Eigen::Index(f)) << x, y, 1.0;
    squares[Eigen::Index(f)] = x * x + y * y;
  }
  const Eigen::Vector3d fit = terms.colPivHouseholderQr().solve(squares);
  return from + 0.5 * fit[0] * orbit.first_direction + 0.5 * fit[1] * orbit.second_direction;
}

/// Where the rays through the detectors' middles pass the axis, in the mean, above a point of it.
double mean_height(const std::vector<ConeBeamFrame>& frames, const Vec3& on_axis,
                   const Vec3& axis) {
  double sum = 0.0;
  for (const ConeBeamFrame& frame : frames) {
    const Vec3 ray =
        normalized(frame.place(0.5 * (frame.columns - 1), 0.5 * (frame.rows - 1)) - frame.source);
    const Vec3 to_axis = on_axis - frame.source;
    const double slope = dot(ray, axis), across = 1.0 - slope * slope;
    const double way = (dot(to_axis, ray) - dot(to_axis, axis) * slope) / across;
    sum += dot(frame.source + way * ray - on_axis, axis);
  }
  return sum / double(frames.size());
}

void place_frames(const std::vector<ConeBeamFrame>& frames, Orbit& orbit) {
  for (const ConeBeamFrame& frame : frames) {
    const Vec3 d = frame.source - orbit.isocentre;
    const double x = dot(d, orbit.first_direction), y = dot(d, orbit.second_direction);
    double angle = std::atan2(y, x);
    if (!orbit.angle.empty())
      angle += 2.0 * units::kPi * std::round((orbit.angle.back() - angle) / (2.0 * units::kPi));
    orbit.angle.push_back(angle);
    orbit.radius.push_back(std::hypot(x, y));
    orbit.height.push_back(dot(d, orbit.axis));
  }
}

/// Each frame stands for the arc to the middle of the way to its neighbours.
void share_arc(Orbit& orbit) {
  const std::size_t count = orbit.angle.size();
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return orbit.angle[a] < orbit.angle[b]; });
  const auto sorted = [&](std::size_t place) { return orbit.angle[order[place]]; };
  orbit.first_angle = sorted(0) - 0.5 * (sorted(1) - sorted(0));
  orbit.last_angle = sorted(count - 1) + 0.5 * (sorted(count - 1) - sorted(count - 2));
  orbit.step.assign(count, 0.0);
  for (std::size_t place = 0; place < count; ++place) {
    const double low = place == 0 ? orbit.first_angle : 0.5 * (sorted(place - 1) + sorted(place));
    const double high =
        place + 1 == count ? orbit.last_angle : 0.5 * (sorted(place) + sorted(place + 1));
    orbit.step[order[place]] = high - low;
    if (place > 0)
      orbit.largest_step = std::max(orbit.largest_step, sorted(place) - sorted(place - 1));
  }
}

}  // namespace

Vec3 Orbit::to_source(std::size_t frame) const {
  return std::cos(angle[frame]) * first_direction + std::sin(angle[frame]) * second_direction;
}
Vec3 Orbit::across(std::size_t frame) const { return cross(axis, to_source(frame)); }

Orbit fit_orbit(const std::vector<ConeBeamFrame>& frames) {
  if (frames.size() < kLeastFrames)
    throw InputError(
        fmt::format("the run has {} frames (a volume needs views from many sides). "
                    "Give a rotational run",
                    frames.size()));
  Orbit orbit;
  orbit.axis = axis_of(frames);
  orbit.first_direction = any_perpendicular(orbit.axis);
  orbit.second_direction = cross(orbit.axis, orbit.first_direction);
  const Vec3 middle = circle_middle(frames, orbit);
  orbit.isocentre = middle + mean_height(frames, middle, orbit.axis) * orbit.axis;
  place_frames(frames, orbit);
  share_arc(orbit);
  if (orbit.arc() < kLeastArc)
    throw InputError(
        fmt::format("the run turns by {:.0f} degrees (depth is not told by an arc "
                    "under 40). Give a rotational run, 180 degrees or more",
                    orbit.arc() / kDegree));
  return orbit;
}

}  // namespace angio::reconstruction::detail

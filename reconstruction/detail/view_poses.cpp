#include "reconstruction/detail/view_poses.hpp"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/units.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr int kNumbers = 6;     ///< of a pose
constexpr double kHuber = 2.0;  ///< [pixels]
constexpr double kReach = 4.0;  ///< of a line from a place that is on it: twice the hull's [mm]
/// A place keeps to where it is along its vessel, which no line tells, by a centimetre [1/mm^2].
constexpr double kHeld = 1.0 / (10.0 * 10.0);

/// How far a view sees a place beside its line.
struct Sighting {
  std::size_t view = 0;
  double off = 0.0;          ///< [pixels]
  Eigen::Vector3d by_place;  ///< [pixels / mm]
};

/// Unit, at right angles to a line around one of its pixels: to the main axis of its pixels there.
/// None: it has no direction (at a fork, or of a stub).
std::optional<std::array<double, 2>> across_line(const VesselLines& lines, int pixel) {
  constexpr int kAround = 4;
  constexpr double kLeastRatio = 4.0;  // of the axes' squares
  const int c = pixel % lines.columns, r = pixel / lines.columns;
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  for (int dy = -kAround; dy <= kAround; ++dy)
    for (int dx = -kAround; dx <= kAround; ++dx) {
      if (c + dx < 0 || c + dx >= lines.columns || r + dy < 0 || r + dy >= lines.rows) continue;
      if (!(lines.radius[std::size_t(r + dy) * std::size_t(lines.columns) + std::size_t(c + dx)] >
            0.0F))
        continue;
      n += 1.0, x += dx, y += dy, xx += dx * dx, xy += dx * dy, yy += dy * dy;
    }
  if (n < kAround) return {};
  xx = xx / n - x * x / (n * n), xy = xy / n - x * y / (n * n), yy = yy / n - y * y / (n * n);
  const double mean = 0.5 * (xx + yy), half = std::hypot(0.5 * (xx - yy), xy);
  if (mean + half < kLeastRatio * (mean - half)) return {};
  const double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
  return std::array{-std::sin(angle), std::cos(angle)};
}

std::optional<Sighting> sight(const ViewLookup& lookup, std::size_t view, const Vec3& place) {
  const LineNear near = lookup.at(place);
  if (!near.is_seen || near.pixel < 0 || near.distance_mm > kReach) return {};
  const VesselLines& lines = lookup.picture().lines;
  const auto across = across_line(lines, near.pixel);
  if (!across) return {};
  const auto off = [&](const Vec3& at) {
    const angiogram::SeenPoint seen = lookup.see(at);
    return (*across)[0] * (seen.column - near.pixel % lines.columns) +
           (*across)[1] * (seen.row - near.pixel / lines.columns);
  };
  constexpr double kStep = 0.01;  // [mm]; the picture changes evenly over it
  Sighting sighting{view, off(place), {}};
  for (int a = 0; a < 3; ++a) {
    const Vec3 by{a == 0 ? kStep : 0.0, a == 1 ? kStep : 0.0, a == 2 ? kStep : 0.0};
    sighting.by_place[a] = (off(place + by) - off(place - by)) / (2.0 * kStep);
  }
  return sighting;
}

Vec3 to_vec3(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

double weight_of(const Sighting& one) {
  const double size = std::abs(one.off);
  return size > kHuber ? kHuber / size : 1.0;
}

struct Normal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};

/// What the sightings of a place tell of its own move, and together with it of the poses.
struct PlaceSums {
  Eigen::Matrix3d own;
  Eigen::Vector3d own_right = Eigen::Vector3d::Zero();
  Eigen::MatrixXd between;
};

/// Adds what one place tells of the poses, its own move eliminated.
void add_place(const Vec3& place, const std::vector<Sighting>& sightings, Normal& normal) {
  const auto numbers = normal.right.size();
  PlaceSums sums{kHeld * Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero(),
                 Eigen::MatrixXd::Zero(3, numbers)};
  const Eigen::Vector3d x{place.x, place.y, place.z};
  for (const Sighting& one : sightings) {
    const double weight = weight_of(one);
    Eigen::VectorXd by = Eigen::VectorXd::Zero(numbers);
    if (one.view > 0) {
      // A C-arm that moves by +shift sees the place where it saw place - shift.
      const auto first = kNumbers * (Eigen::Index(one.view) - 1);
      by.segment<3>(first) = -x.cross(one.by_place);
      by.segment<3>(first + 3) = -one.by_place;
    }
    normal.matrix += weight * by * by.transpose();
    normal.right -= weight * one.off * by;
    sums.own += weight * one.by_place * one.by_place.transpose();
    sums.own_right -= weight * one.off * one.by_place;
    sums.between += weight * one.by_place * by.transpose();
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(sums.own);
  normal.matrix -= sums.between.transpose() * solver.solve(sums.between);
  normal.right -= sums.between.transpose() * solver.solve(sums.own_right);
}

/// Moves a place to where its sightings meet.
void meet(const std::vector<Sighting>& sightings, Vec3& place) {
  Eigen::Matrix3d own = kHeld * Eigen::Matrix3d::Identity();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Sighting& one : sightings) {
    own += weight_of(one) * one.by_place * one.by_place.transpose();
    right -= weight_of(one) * one.off * one.by_place;
  }
  place += to_vec3(own.ldlt().solve(right));
}

std::vector<Sighting> sightings_of(const std::vector<ViewPicture>& views, const Vec3& place) {
  std::vector<Sighting> sightings;
  for (std::size_t v = 0; v < views.size(); ++v)
    if (const auto one = sight(ViewLookup(views[v]), v, place)) sightings.push_back(*one);
  return sightings;
}

/// One step of Gauss and Newton.
void improve(const std::vector<ViewPicture>& views, const std::vector<Vec3>& places,
             const PosePrior& prior, std::vector<ViewPose>& poses) {
  const auto numbers = kNumbers * (Eigen::Index(views.size()) - 1);
  Normal normal{Eigen::MatrixXd::Zero(numbers, numbers), Eigen::VectorXd::Zero(numbers)};
  for (const Vec3& place : places) {
    const std::vector<Sighting> sightings = sightings_of(views, place);
    if (sightings.size() > 2) add_place(place, sightings, normal);
  }
  const double turn_sd = units::kPi / 180.0 * prior.turn_sd_degrees;
  for (std::size_t v = 1; v < views.size(); ++v) {
    const auto first = kNumbers * (Eigen::Index(v) - 1);
    Eigen::VectorXd at(kNumbers), information(kNumbers);
    at << poses[v].turn.x, poses[v].turn.y, poses[v].turn.z, poses[v].shift.x, poses[v].shift.y,
        poses[v].shift.z;
    information.head<3>().setConstant(1.0 / (turn_sd * turn_sd));
    information.tail<3>().setConstant(1.0 / (prior.shift_sd_mm * prior.shift_sd_mm));
    normal.matrix.diagonal().segment(first, kNumbers) += information;
    normal.right.segment(first, kNumbers) -= information.cwiseProduct(at);
  }
  const Eigen::VectorXd step = normal.matrix.ldlt().solve(normal.right);
  for (std::size_t v = 1; v < views.size(); ++v) {
    const auto first = kNumbers * (Eigen::Index(v) - 1);
    poses[v].turn += to_vec3(step.segment<3>(first));
    poses[v].shift += to_vec3(step.segment<3>(first + 3));
  }
}

}  // namespace

Vec3 posed(const Vec3& place, const ViewPose& pose) {
  const Eigen::Vector3d turn{pose.turn.x, pose.turn.y, pose.turn.z};
  const double angle = turn.norm();
  if (angle == 0.0) return place + pose.shift;
  return to_vec3(Eigen::AngleAxisd(angle, turn / angle) *
                 Eigen::Vector3d{place.x, place.y, place.z}) +
         pose.shift;
}

angiogram::ConeBeamFrame posed(angiogram::ConeBeamFrame frame, const ViewPose& pose) {
  const auto turned = [&](const Vec3& step) { return posed(step, {pose.turn, {}}); };
  frame.source = posed(frame.source, pose);
  frame.first_pixel = posed(frame.first_pixel, pose);
  frame.column_step = turned(frame.column_step);
  frame.row_step = turned(frame.row_step);
  return frame;
}

std::vector<ViewPose> find_view_poses(std::vector<ViewPicture> views, const CenterlineTree& tree,
                                      std::vector<ViewPose> poses, const PosePrior& prior) {
  constexpr int kRounds = 12;
  std::vector<angiogram::ConeBeamFrame> as_given;
  for (const ViewPicture& view : views) as_given.push_back(view.frame);
  const auto take_poses = [&] {
    for (std::size_t v = 1; v < views.size(); ++v) views[v].frame = posed(as_given[v], poses[v]);
  };
  std::vector<Vec3> places;
  for (const CenterlinePath& path : tree.paths)
    places.insert(places.end(), path.points.begin(), path.points.end());
  take_poses();
  for (int round = 0; round < kRounds; ++round) {
    improve(views, places, prior, poses);
    take_poses();
    for (Vec3& place : places) meet(sightings_of(views, place), place);
  }
  return poses;
}

}  // namespace angio::reconstruction::detail

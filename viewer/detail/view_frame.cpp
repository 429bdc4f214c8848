#include "viewer/detail/view_frame.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include "core/units.hpp"

namespace angio::viewer::detail {
namespace {

constexpr double kMargin = 1.06;  // free space around what is framed
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Interval {
  double low = kInfinity;
  double high = -kInfinity;
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double middle() const { return low <= high ? 0.5 * (low + high) : 0.0; }
  [[nodiscard]] double length() const { return low <= high ? high - low : 0.0; }
};

Interval extent(const std::vector<Vec3>& points, const Vec3& axis) {
  Interval interval;
  for (const Vec3& point : points) interval.add(dot(point, axis));
  return interval;
}

/// Centres the frame on the points and opens it to hold them all.
void fit(ViewFrame& frame, const std::vector<Vec3>& points) {
  const Vec3 right = frame.right();
  const Interval x = extent(points, right);
  const Interval y = extent(points, frame.up);
  const Interval z = extent(points, frame.direction);
  frame.focus = x.middle() * right + y.middle() * frame.up + z.middle() * frame.direction;
  const double least = std::max(1e-3, 0.1 * std::max(x.length(), y.length()));
  frame.half_width_mm = 0.5 * kMargin * std::max(least, x.length());
  frame.half_height_mm = 0.5 * kMargin * std::max(least, y.length());
}

Mat3 covariance(const std::vector<Vec3>& points) {
  Vec3 mean;
  for (const Vec3& point : points) mean += point;
  mean *= 1.0 / double(points.size());
  Mat3 sum;
  for (const Vec3& point : points) sum += outer(point - mean, point - mean);
  return (1.0 / double(points.size())) * sum;
}

/// The eigenvector of the least eigenvalue of a symmetric, positive semi-definite matrix: power
/// iteration on trace(A) I - A, whose largest eigenvalue belongs to it.
Vec3 least_axis(const Mat3& a) {
  const double trace = a(0, 0) + a(1, 1) + a(2, 2);
  if (trace <= 0.0) return {0, 1, 0};
  Mat3 shifted = (-1.0 / trace) * a;
  shifted += Mat3::identity();
  Vec3 axis = normalized(Vec3{0.1, 1.0, 0.2});
  for (int i = 0; i < 2000; ++i) axis = normalized(shifted * axis);
  return axis;
}

Vec3 without(const Vec3& v, const Vec3& unit_axis) { return v - dot(v, unit_axis) * unit_axis; }

/// Sideways extent of the wall at the lesion, the depth of the whole wall, and what lies in front.
struct ProfileJudge {
  std::vector<Vec3> at_lesion;
  const TriangleMesh& wall;
  const TriangleMesh& other;
  Vec3 lesion;
  double wall_length_mm;

  /// Lower is better; every term is about 0 to 1.
  [[nodiscard]] double score(const Vec3& direction, const Vec3& up, double widest_mm) const {
    const double width = extent(at_lesion, up).length() / std::max(widest_mm, 1e-9);
    const double depth = extent(wall.vertices, direction).length() / wall_length_mm;
    int in_front = 0;
    for (const Vec3& point : other.vertices) {
      const Vec3 d = point - lesion;
      const bool is_over = norm(without(d, direction)) < 0.35 * wall_length_mm;
      if (is_over && dot(d, direction) < -widest_mm) ++in_front;
    }
    const double hidden = double(in_front) / (1.0 + double(other.vertices.size()));
    return width + 0.5 * depth + 2.0 * hidden;
  }
};

}  // namespace

ViewFrame frame_tree(const TriangleMesh& mesh, const std::optional<Vec3>& rather) {
  constexpr double kHardlyDeeper = 2.0;
  ViewFrame frame;
  if (mesh.vertices.empty()) return frame;
  const Mat3 spread = covariance(mesh.vertices);
  frame.direction = least_axis(spread);
  const auto depth = [&](const Vec3& direction) { return dot(direction, spread * direction); };
  if (rather && depth(*rather) <= kHardlyDeeper * depth(frame.direction)) frame.direction = *rather;
  const double facing = frame.direction.y + 0.01 * frame.direction.x + 0.001 * frame.direction.z;
  if (facing < 0.0) frame.direction = -frame.direction;
  const Vec3 head = without({0, 0, 1}, frame.direction);
  // Seen along the body's axis there is no "head up"; then the front is up, as in an axial slice.
  frame.up = normalized(norm(head) > 0.3 ? head : without({0, -1, 0}, frame.direction));
  fit(frame, mesh.vertices);
  return frame;
}

void include_circle(ViewFrame& frame, const Vec3& centre, double radius_mm) {
  const auto open = [&](const Vec3& axis, double& half) {
    const double at = dot(centre - frame.focus, axis), reach = kMargin * radius_mm;
    const double low = std::min(-half, at - reach), high = std::max(half, at + reach);
    half = 0.5 * (high - low);
    return 0.5 * (high + low);
  };
  const Vec3 right = frame.right();
  const double x = open(right, frame.half_width_mm), y = open(frame.up, frame.half_height_mm);
  frame.focus += x * right + y * frame.up;
}

ViewFrame frame_lesion(const TriangleMesh& wall, const TriangleMesh& other,
                       const CenterlinePath& path, double abscissa_mm) {
  const CenterlineSample lesion = sample(path, abscissa_mm);
  const double reach = 0.35 * bounds(wall).radius_mm;
  const Vec3 chord =
      normalized(sample(path, abscissa_mm + reach).point - sample(path, abscissa_mm - reach).point);
  const Vec3 right = norm(chord) > 0.5 ? chord : lesion.tangent;
  const Vec3 side_u = any_perpendicular(right);
  const Vec3 side_v = cross(right, side_u);

  ProfileJudge judge{
      {}, wall, other, lesion.point, std::max(extent(wall.vertices, right).length(), 1e-9)};
  const double slab = std::max(0.5 * lesion.inscribed_radius, 0.02 * judge.wall_length_mm);
  for (const Vec3& vertex : wall.vertices)
    if (std::abs(dot(vertex - lesion.point, lesion.tangent)) < slab &&
        norm(vertex - lesion.point) < 6.0 * lesion.inscribed_radius + slab)
      judge.at_lesion.push_back(vertex);

  constexpr int kAngles = 48;
  const auto up_at = [&](int step) {
    const double angle = 2.0 * units::kPi * step / kAngles;
    return std::cos(angle) * side_u + std::sin(angle) * side_v;
  };
  double widest = 0.0;
  for (int step = 0; step < kAngles; ++step)
    widest = std::max(widest, extent(judge.at_lesion, up_at(step)).length());

  ViewFrame best;
  double best_score = kInfinity;
  for (int step = 0; step < kAngles; ++step) {
    const Vec3 up = up_at(step);
    const Vec3 direction = cross(up, right);  // so that direction x up = right
    const double score = judge.score(direction, up, widest);
    if (score < best_score - 1e-9) {
      best_score = score;
      best.direction = direction;
      best.up = up;
    }
  }
  fit(best, wall.vertices);
  return best;
}

TriangleMesh surroundings(const TriangleMesh& lumen, const TriangleMesh& wall, const Vec3& center,
                          double radius_mm) {
  using Key = std::tuple<long long, long long, long long>;
  const auto key = [](const Vec3& p) {
    return Key{std::llround(p.x * 1e4), std::llround(p.y * 1e4), std::llround(p.z * 1e4)};
  };
  std::set<Key> wall_points;
  for (const Vec3& vertex : wall.vertices) wall_points.insert(key(vertex));

  TriangleMesh result;
  std::vector<int> new_index(lumen.vertices.size(), -1);
  for (const Triangle& triangle : lumen.triangles) {
    bool is_wall = true;
    bool is_near = true;
    for (const int corner : triangle) {
      const Vec3& point = lumen.vertices[std::size_t(corner)];
      is_wall = is_wall && wall_points.count(key(point)) > 0;
      is_near = is_near && distance(point, center) < radius_mm;
    }
    if (is_wall || !is_near) continue;
    Triangle kept{};
    for (std::size_t c = 0; c < 3; ++c) {
      int& index = new_index[std::size_t(triangle[c])];
      if (index < 0) {
        index = int(result.vertices.size());
        result.vertices.push_back(lumen.vertices[std::size_t(triangle[c])]);
      }
      kept[c] = index;
    }
    result.triangles.push_back(kept);
  }
  return result;
}

Bounds bounds(const TriangleMesh& mesh) {
  const Interval x = extent(mesh.vertices, {1, 0, 0});
  const Interval y = extent(mesh.vertices, {0, 1, 0});
  const Interval z = extent(mesh.vertices, {0, 0, 1});
  return {{x.middle(), y.middle(), z.middle()},
          0.5 * norm(Vec3{x.length(), y.length(), z.length()})};
}

}  // namespace angio::viewer::detail

#include "angiogram/shadow.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace angio::angiogram {
namespace {

constexpr int kPlaces = 40;  // along the segment
constexpr std::array kAcross{-0.8, -0.4, 0.0, 0.4, 0.8};

/// A point of the picture.
struct Flat {
  double x = 0.0, y = 0.0;
};

Flat flat(const Vec3& point, const CArmAxes& axes) {
  return {dot(point, axes.right), dot(point, axes.up)};
}

double radius_at(const CenterlinePath& path, double abscissa) {
  const std::vector<double>& radius = measured_radius(path);
  const auto above = std::lower_bound(path.abscissa.begin(), path.abscissa.end(), abscissa);
  if (above == path.abscissa.begin()) return radius.front();
  if (above == path.abscissa.end()) return radius.back();
  const auto i = std::size_t(above - path.abscissa.begin());
  const double t = (abscissa - path.abscissa[i - 1]) / (path.abscissa[i] - path.abscissa[i - 1]);
  return (1.0 - t) * radius[i - 1] + t * radius[i];
}

/// How many points two lines have in common from the inlet on.
std::size_t shared_count(const CenterlinePath& a, const CenterlinePath& b) {
  std::size_t i = 0;
  while (i < a.points.size() && i < b.points.size() && a.points[i] == b.points[i]) ++i;
  return i;
}

}  // namespace

SegmentShadow::SegmentShadow(const CenterlineTree& tree, const ViewedSegment& segment)
    : throat_(segment.throat), throat_tangent_(segment.throat_tangent) {
  if (segment.path >= tree.paths.size() || tree.paths[segment.path].points.size() < 2)
    throw InputError("the tree has no line for a working view. Run `angio centerline` again");
  const CenterlinePath& path = tree.paths[segment.path];
  const double first = std::max(segment.first_mm, path.abscissa.front());
  const double last = std::min(segment.last_mm, path.abscissa.back());
  if (!(first < last))
    throw InputError("the line has no segment for a working view (it is empty). Choose another");
  for (int i = 0; i < kPlaces; ++i) {
    const double abscissa = first + (last - first) * i / (kPlaces - 1);
    segment_.push_back({sample(path, abscissa).point, radius_at(path, abscissa)});
  }
  add_pieces(tree, {segment.path, first, last});
}

void SegmentShadow::add_pieces(const CenterlineTree& tree, const ViewedSegment& segment) {
  double widest = 0.0;
  for (const Ball& ball : segment_) widest = std::max(widest, ball.radius);
  const CenterlinePath& own = tree.paths[segment.path];
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    const CenterlinePath& path = tree.paths[p];
    const std::vector<double>& radius = measured_radius(path);
    const std::size_t shared = p == segment.path ? path.points.size() : shared_count(own, path);
    const double fork = shared > 0 ? path.abscissa[shared - 1] : path.abscissa.front();
    // How far along the tree a point is from the segment.
    const auto away = [&](std::size_t i) {
      const double s = path.abscissa[i], leaves = std::min(s, fork);
      return std::max({segment.first_mm - leaves, leaves - segment.last_mm, 0.0}) + s - leaves;
    };
    // What an earlier line has given is not given again.
    std::size_t start = 0;
    for (std::size_t q = 0; q < p; ++q) start = std::max(start, shared_count(tree.paths[q], path));
    Ball last;
    bool has_last = false;
    for (std::size_t i = start > 0 ? start - 1 : 0; i < path.points.size(); ++i) {
      const Ball ball{path.points[i], radius[i]};
      if (away(i) < widest + ball.radius) {
        has_last = false;
        continue;
      }
      const bool is_end = i + 1 == path.points.size();
      if (has_last && !is_end && distance(ball.point, last.point) < 0.5 * ball.radius) continue;
      if (has_last) others_.push_back({last, ball});
      last = ball;
      has_last = true;
    }
  }
}

SeenSegment SegmentShadow::seen(const CArmAngles& angles) const {
  const CArmAxes axes = c_arm_axes(angles);
  double length = 0.0, seen = 0.0;
  for (std::size_t i = 0; i + 1 < segment_.size(); ++i) {
    const Vec3 step = segment_[i + 1].point - segment_[i].point;
    length += norm(step);
    seen += std::hypot(dot(step, axes.right), dot(step, axes.up));
  }
  const double hidden = length > 0.0 ? 1.0 - seen / length : 0.0;
  return {angles, 100.0 * std::clamp(hidden, 0.0, 1.0), overlap_percent(axes), throat_mm(axes)};
}

/// Its extent across the vessel as it is seen.
double SegmentShadow::throat_mm(const CArmAxes& axes) const {
  const Flat along{dot(throat_tangent_, axes.right), dot(throat_tangent_, axes.up)};
  const double length = std::hypot(along.x, along.y);
  if (throat_.empty() || length <= 0.0) return 0.0;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3& point : throat_) {
    const Flat at = flat(point, axes);
    const double across = (at.y * along.x - at.x * along.y) / length;
    low = std::min(low, across);
    high = std::max(high, across);
  }
  return high - low;
}

double SegmentShadow::overlap_percent(const CArmAxes& axes) const {
  std::vector<Flat> points;
  for (std::size_t i = 0; i < segment_.size(); ++i) {
    const Flat before = flat(segment_[i == 0 ? 0 : i - 1].point, axes);
    const Flat behind = flat(segment_[std::min(i + 1, segment_.size() - 1)].point, axes);
    const double dx = behind.x - before.x, dy = behind.y - before.y, step = std::hypot(dx, dy);
    // Seen end on a vessel has no side: any will do.
    const Flat side = step > 0.0 ? Flat{-dy / step, dx / step} : Flat{1.0, 0.0};
    const Flat middle = flat(segment_[i].point, axes);
    for (const double share : kAcross)
      points.push_back({middle.x + share * segment_[i].radius * side.x,
                        middle.y + share * segment_[i].radius * side.y});
  }
  Flat low = points.front(), high = low;
  for (const Flat& point : points) {
    low = {std::min(low.x, point.x), std::min(low.y, point.y)};
    high = {std::max(high.x, point.x), std::max(high.y, point.y)};
  }
  std::vector<char> is_hidden(points.size(), 0);
  for (const Piece& piece : others_) {
    const Flat a = flat(piece.a.point, axes), b = flat(piece.b.point, axes);
    const double r = std::max(piece.a.radius, piece.b.radius);
    if (std::max(a.x, b.x) + r < low.x || std::min(a.x, b.x) - r > high.x ||
        std::max(a.y, b.y) + r < low.y || std::min(a.y, b.y) - r > high.y)
      continue;
    const double dx = b.x - a.x, dy = b.y - a.y, squared = dx * dx + dy * dy;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double along = (points[i].x - a.x) * dx + (points[i].y - a.y) * dy;
      const double t = squared > 0.0 ? std::clamp(along / squared, 0.0, 1.0) : 0.0;
      const double away = std::hypot(points[i].x - a.x - t * dx, points[i].y - a.y - t * dy);
      if (away < (1.0 - t) * piece.a.radius + t * piece.b.radius) is_hidden[i] = 1;
    }
  }
  const auto count = std::count(is_hidden.begin(), is_hidden.end(), char(1));
  return 100.0 * double(count) / double(points.size());
}

}  // namespace angio::angiogram

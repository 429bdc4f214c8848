#include "centerline/detail/side_by_side.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "centerline/detail/contour.hpp"
#include "centerline/detail/places.hpp"
#include "centerline/detail/tracts.hpp"
#include "core/parallel.hpp"

namespace angio::centerline {
namespace {

constexpr double kWaist = 0.85;       ///< of the lower maximum: a narrower place is a waist
constexpr double kBothSides = 0.25;   ///< of the notches that each side must have
constexpr double kLobe = 0.4;         ///< least length of what lies beside a waist, in its height
constexpr double kLeastLength = 2.0;  ///< widths of the section: shorter ones are branchings
constexpr double kLeastShare = 0.8;   ///< of the points of a stretch that have a waist
constexpr double kReach = 6.0;        ///< radii to each side that are looked at
constexpr double kOblong = 1.25;      ///< length over height: rounder sections hold one vessel
constexpr double kStep = 0.5;         ///< radii between points that are looked at

/// A grid of level-set values in a plane; the middle one is its origin.
class PlaneGrid {
 public:
  PlaneGrid(const Volume<float>& level_set, const Vec3& origin, const Vec3& u, const Vec3& v,
            double reach_u, double reach_v, int half)
      : half_(half), side_(2 * half + 1), step_u_(reach_u / half), step_v_(reach_v / half) {
    const VolumeGeometry& grid = level_set.geometry;
    values_.reserve(std::size_t(side_ * side_));
    for (int b = -half; b <= half; ++b)
      for (int a = -half; a <= half; ++a) {
        const Vec3 p = origin + (a * step_u_) * u + (b * step_v_) * v;
        const Vec3 i = grid.index_from_lps(p);
        const bool is_beyond = i.x < 0.0 || i.y < 0.0 || i.z < 0.0 || i.x > grid.size[0] - 1 ||
                               i.y > grid.size[1] - 1 || i.z > grid.size[2] - 1;
        values_.push_back(is_beyond ? 1.0 : interpolate(level_set, p));
      }
  }

  [[nodiscard]] int side() const { return side_; }
  [[nodiscard]] double value(int a, int b) const { return values_[std::size_t(b * side_ + a)]; }
  [[nodiscard]] Point2 place(int a, int b) const {
    return {(a - half_) * step_u_, (b - half_) * step_v_};
  }
  [[nodiscard]] double step_v() const { return step_v_; }

  /// Which values are inside and connected with the one nearest to a place; empty if that one is
  /// not inside or the piece meets the border.
  [[nodiscard]] std::vector<char> piece_at(const Point2& start) const {
    const auto nearest = [&](double x, double step) {
      return std::clamp(half_ + int(std::lround(x / step)), 0, side_ - 1);
    };
    std::vector<int> stack{nearest(start.y, step_v_) * side_ + nearest(start.x, step_u_)};
    if (values_[std::size_t(stack.back())] >= 0.0) return {};
    std::vector<char> piece(values_.size(), 0);
    piece[std::size_t(stack.back())] = 1;
    while (!stack.empty()) {
      const int n = stack.back(), a = n % side_, b = n / side_;
      stack.pop_back();
      if (a == 0 || b == 0 || a == side_ - 1 || b == side_ - 1) return {};
      for (const int other : {n - 1, n + 1, n - side_, n + side_}) {
        if (piece[std::size_t(other)] != 0 || values_[std::size_t(other)] >= 0.0) continue;
        piece[std::size_t(other)] = 1;
        stack.push_back(other);
      }
    }
    return piece;
  }

 private:
  int half_, side_;
  double step_u_, step_v_;
  std::vector<double> values_;
};

/// An oblong piece of a plane: where it lies and which way it is long.
struct Oblong {
  Point2 middle, axis;
  double half_length = 0.0, half_height = 0.0;  ///< that hold all of it
};

/// Nothing where the piece is round.
std::optional<Oblong> measure_oblong(const PlaneGrid& grid, const std::vector<char>& piece) {
  std::vector<Point2> points;
  Oblong result;
  for (int b = 0; b < grid.side(); ++b)
    for (int a = 0; a < grid.side(); ++a)
      if (piece[std::size_t(b * grid.side() + a)] != 0) points.push_back(grid.place(a, b));
  for (const Point2& p : points) {
    result.middle.x += p.x / double(points.size());
    result.middle.y += p.y / double(points.size());
  }
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (const Point2& p : points) {
    const double x = p.x - result.middle.x, y = p.y - result.middle.y;
    xx += x * x;
    xy += x * y;
    yy += y * y;
  }
  const double gap = std::hypot(0.5 * (xx - yy), xy), mean = 0.5 * (xx + yy);
  if (mean + gap < kOblong * kOblong * (mean - gap)) return std::nullopt;
  const double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
  result.axis = {std::cos(angle), std::sin(angle)};
  for (const Point2& p : points) {
    const double x = p.x - result.middle.x, y = p.y - result.middle.y;
    result.half_length =
        std::max(result.half_length, std::abs(x * result.axis.x + y * result.axis.y));
    result.half_height =
        std::max(result.half_height, std::abs(y * result.axis.x - x * result.axis.y));
  }
  return result;
}

/// A column of a piece, across its longer axis.
struct Column {
  double x = 0.0, top = 0.0, bottom = 0.0;
  [[nodiscard]] double height() const { return top - bottom; }
};

std::vector<Column> columns_of(const PlaneGrid& grid, const std::vector<char>& piece) {
  std::vector<Column> columns;
  for (int a = 0; a < grid.side(); ++a) {
    int low = grid.side(), high = -1;
    for (int b = 0; b < grid.side(); ++b)
      if (piece[std::size_t(b * grid.side() + a)] != 0) {
        low = std::min(low, b);
        high = b;
      }
    if (high < 0) continue;
    // To where the level set is zero.
    const auto beyond = [&](int from, int side) {
      const double here = grid.value(a, from), there = grid.value(a, from + side);
      return grid.step_v() * here / (here - there);
    };
    columns.push_back({grid.place(a, high).x, grid.place(a, high).y + beyond(high, 1),
                       grid.place(a, low).y - beyond(low, -1)});
  }
  return columns;
}

/// The most that some columns reach.
struct Most {
  double height = 0.0, top = -1e300, bottom = 1e300;
  void add(const Column& column) {
    height = std::max(height, column.height());
    top = std::max(top, column.top);
    bottom = std::min(bottom, column.bottom);
  }
};

/// Whether a section is like an 8.
bool has_waist(const std::vector<Column>& columns) {
  const std::size_t count = columns.size();
  std::vector<Most> behind(count);
  for (std::size_t c = count; c-- > 1;) {
    behind[c - 1] = behind[c];
    behind[c - 1].add(columns[c]);
  }
  Most before;
  for (std::size_t c = 0; c < count; before.add(columns[c++])) {
    const Column& here = columns[c];
    const Most& after = behind[c];
    if (here.height() > kWaist * std::min(before.height, after.height)) continue;
    const double above = std::min(before.top, after.top) - here.top;
    const double below = here.bottom - std::max(before.bottom, after.bottom);
    if (std::min(above, below) >= kBothSides * (above + below) &&
        here.x - columns.front().x >= kLobe * before.height &&
        columns.back().x - here.x >= kLobe * after.height)
      return true;
  }
  return false;
}

/// The width of a section that is like an 8; 0 of others.
double waisted_width(const CenterlinePath& path, std::size_t i, const Volume<float>& level_set) {
  constexpr int kCoarse = 16, kFine = 32;  // values to each side
  const CenterlineSample here = sample(path, path.abscissa[i]);
  const Vec3 u = any_perpendicular(here.tangent), v = cross(here.tangent, u);
  const double reach = kReach * path.inscribed_radius[i];
  const PlaneGrid coarse(level_set, here.point, u, v, reach, reach, kCoarse);
  const std::vector<char> seen = coarse.piece_at({});
  if (seen.empty()) return 0.0;
  const auto oblong = measure_oblong(coarse, seen);
  if (!oblong) return 0.0;
  const Point2 &m = oblong->middle, &axis = oblong->axis;
  const double margin = 2.0 * reach / kCoarse;
  const PlaneGrid fine(level_set, here.point + m.x * u + m.y * v, axis.x * u + axis.y * v,
                       axis.x * v - axis.y * u, oblong->half_length + margin,
                       oblong->half_height + margin, kFine);
  const std::vector<char> piece =
      fine.piece_at({-(m.x * axis.x + m.y * axis.y), m.x * axis.y - m.y * axis.x});
  if (piece.empty()) return 0.0;
  const std::vector<Column> columns = columns_of(fine, piece);
  return has_waist(columns) ? columns.back().x - columns.front().x : 0.0;
}

/// Points of a line at steps of half the radius, and the widths of their sections.
struct Looked {
  std::vector<std::size_t> points;
  std::vector<double> widths;
};

/// @param known   what was seen along another line
/// @param shared  points that both begin with; there it is not looked again
Looked look_along(const CenterlinePath& path, const Volume<float>& level_set, const Looked& known,
                  std::size_t shared) {
  Looked looked;
  double next = 0.0;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    if (path.abscissa[i] < next) continue;
    looked.points.push_back(i);
    next = path.abscissa[i] + kStep * path.inscribed_radius[i];
  }
  looked.widths.assign(looked.points.size(), 0.0);
  parallel_for_uneven(std::ptrdiff_t(looked.points.size()), [&](std::ptrdiff_t n) {
    const auto at = std::size_t(n);
    const std::size_t point = looked.points[at];
    const bool is_known =
        point + 1 < shared && at < known.points.size() && known.points[at] == point;
    looked.widths[at] = is_known ? known.widths[at] : waisted_width(path, point, level_set);
  });
  return looked;
}

std::string warning_at(const Vec3& place, double length) {
  return "two vessels seem to run side by side as one lumen around " + in_words(place) + ", for " +
         std::to_string(std::lround(length)) +
         " mm (the sections are like an 8); lines, radii and areas there are not those of one "
         "vessel. Check the place";
}

}  // namespace

std::vector<std::string> find_vessels_side_by_side(const CenterlineTree& tree,
                                                   const Volume<float>& level_set) {
  std::vector<std::string> warnings;
  std::vector<std::pair<Vec3, double>> found;  // places and lengths
  std::vector<Looked> looked;
  for (const CenterlinePath& path : tree.paths) {
    std::size_t shared = 0, with = 0;
    for (std::size_t other = 0; other < looked.size(); ++other)
      if (const auto count = std::size_t(count_shared(path, tree.paths[other])); count > shared) {
        shared = count;
        with = other;
      }
    looked.push_back(look_along(path, level_set, shared > 0 ? looked[with] : Looked{}, shared));
    const auto& [points, widths] = looked.back();
    for (std::size_t begin = 0; begin < points.size(); ++begin) {
      if (widths[begin] <= 0.0) continue;
      // To the last section like that which is less than half a width behind the one before.
      std::size_t last = begin, count = 1;
      double width = widths[begin];
      for (std::size_t n = begin + 1; n < points.size(); ++n) {
        if (path.abscissa[points[n]] - path.abscissa[points[last]] > 0.5 * widths[last]) break;
        if (widths[n] <= 0.0) continue;
        last = n;
        width += widths[n];
        ++count;
      }
      width /= double(count);
      const double length = path.abscissa[points[last]] - path.abscissa[points[begin]];
      const Vec3 place = path.points[points[(begin + last) / 2]];
      const bool is_known = std::any_of(found.begin(), found.end(), [&](const auto& other) {
        return distance(other.first, place) < 0.5 * (other.second + length);
      });
      if (length >= kLeastLength * width && !is_known &&
          double(count) >= kLeastShare * double(last - begin + 1)) {
        found.emplace_back(place, length);
        warnings.push_back(warning_at(place, length));
      }
      begin = last;
    }
  }
  return warnings;
}

}  // namespace angio::centerline

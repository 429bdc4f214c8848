#include "reconstruction/detail/view_vessel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_map>
#include <utility>

#include "core/statistics.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/picture_size.hpp"

namespace angio::reconstruction::detail {
namespace {

/// Pixels from one to another.
std::vector<int> cheapest_path(const ViewPicture& view, int from, int to) {
  constexpr float kFarthest = 8.0F;
  const int columns = view.lines.columns, rows = view.lines.rows;
  std::vector<float> cost(view.lines.radius.size(), std::numeric_limits<float>::infinity());
  std::vector<int> before(cost.size(), -1);
  using Entry = std::pair<float, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto step_cost = [&](int pixel) {
    const float away = std::min(kFarthest, view.distance[std::size_t(pixel)]);
    return 1.0F + away * away;
  };
  cost[std::size_t(from)] = 0.0F;
  queue.emplace(0.0F, from);
  while (!queue.empty()) {
    const auto [so_far, here] = queue.top();
    queue.pop();
    if (here == to) break;
    if (so_far > cost[std::size_t(here)]) continue;
    const int c = here % columns, r = here / columns;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (c + dx < 0 || c + dx >= columns || r + dy < 0 || r + dy >= rows) continue;
        const int next = (r + dy) * columns + c + dx;
        const float way =
            (dx != 0 && dy != 0 ? 1.41421F : 1.0F) * 0.5F * (step_cost(here) + step_cost(next));
        if (so_far + way >= cost[std::size_t(next)]) continue;
        cost[std::size_t(next)] = so_far + way;
        before[std::size_t(next)] = here;
        queue.emplace(so_far + way, next);
      }
  }
  std::vector<int> path;
  for (int at = to; at >= 0; at = before[std::size_t(at)]) path.push_back(at);
  std::reverse(path.begin(), path.end());
  return path;
}

/// The mean of a pixel and those around it; the border's go on outside.
double mean_around(const std::vector<float>& picture, const PictureSize& size, double column,
                   double row) {
  const int c = int(std::lround(column)), r = int(std::lround(row));
  double sum = 0.0;
  for (int y = r - 1; y <= r + 1; ++y)
    for (int x = c - 1; x <= c + 1; ++x)
      sum += double(
          picture[size.at(std::clamp(x, 0, size.columns - 1), std::clamp(y, 0, size.rows - 1))]);
  return sum / 9.0;
}

/// How far from a line the picture is compared with it [pixels].
float beside(float radius) { return 1.5F * radius + 1.0F; }

/// How much a line falls to both sides, of how far it falls at all: 1 for a tube, 0 for an edge.
double fall_to_both_sides(const std::vector<float>& picture, const PictureSize& size, int pixel,
                          float radius) {
  constexpr int kDirections = 8;  // of half a turn
  const int c = pixel % size.columns, r = pixel / size.columns;
  const double middle = mean_around(picture, size, c, r);
  double both = 0.0, most = 1e-9;
  for (int n = 0; n < kDirections; ++n) {
    const double angle = units::kPi * n / kDirections, x = double(beside(radius)) * std::cos(angle),
                 y = double(beside(radius)) * std::sin(angle);
    const double one = middle - mean_around(picture, size, c + x, r + y),
                 other = middle - mean_around(picture, size, c - x, r - y);
    both = std::max(both, std::min(one, other));
    most = std::max({most, one, other});
  }
  return both / most;
}

/// The falls of a line that are known, in square cells, so that those near a pixel are found
/// without a look at all of them.
class KnownFalls {
 public:
  KnownFalls(const VesselLines& lines, const std::vector<std::size_t>& piece,
             const ViewPicture& kept) {
    constexpr float kRadii = 1.2F;  // of the kept vessel
    const PictureSize size{lines.columns, lines.rows};
    cells_.columns = 1 + size.columns / kCell;
    cells_.rows = 1 + size.rows / kCell;
    for (const std::size_t i : piece) {
      const int line = kept.nearest[i];
      if (line >= 0 && kept.distance[i] <=
                           beside(lines.radius[i]) + kRadii * kept.lines.radius[std::size_t(line)])
        continue;
      const int column = int(i) % size.columns, row = int(i) / size.columns;
      in_cell_[cells_.at(column / kCell, row / kCell)].push_back(
          {column, row, fall_to_both_sides(kept.vessels, size, int(i), lines.radius[i])});
    }
  }
  [[nodiscard]] bool empty() const { return in_cell_.empty(); }
  /// The median of those known the nearest to a pixel, up to a line's radius on.
  [[nodiscard]] double around(int column, int row, double radius) const {
    constexpr double kLeast = 3.0;  // [pixels]
    double nearest = std::numeric_limits<double>::infinity();
    // What lies in a ring of cells is at least its number of cells, less one, away.
    for (int ring = 0; kCell * (ring - 1) < nearest; ++ring)
      visit_ring(column, row, ring, [&](const Fall& fall) {
        nearest = std::min(nearest, std::hypot(fall.column - column, fall.row - row));
      });
    const double reach = nearest + std::max(kLeast, radius);
    std::vector<double> near;
    for (int ring = 0; kCell * (ring - 1) <= reach; ++ring)
      visit_ring(column, row, ring, [&](const Fall& fall) {
        if (std::hypot(fall.column - column, fall.row - row) <= reach)
          near.push_back(fall.both_sides);
      });
    return median(std::move(near));
  }

 private:
  static constexpr int kCell = 8;  ///< [pixels]
  struct Fall {
    int column, row;
    double both_sides;
  };
  template <typename Visit>
  void visit_ring(int column, int row, int ring, const Visit& visit) const {
    const int c = column / kCell, r = row / kCell;
    for (int y = r - ring; y <= r + ring; ++y)
      for (int x = c - ring; x <= c + ring; x += y == r - ring || y == r + ring ? 1 : 2 * ring) {
        if (!cells_.holds(x, y)) continue;
        const auto found = in_cell_.find(cells_.at(x, y));
        if (found != in_cell_.end())
          std::for_each(found->second.begin(), found->second.end(), visit);
      }
  }

  PictureSize cells_;
  std::unordered_map<std::size_t, std::vector<Fall>> in_cell_;
};

/// Lines but the kept vessel's.
struct OtherLines {
  ViewPicture vessels;
  ViewPicture edges;  ///< those that fall to one side only, and pieces all of which lie so near to
                      ///< the kept vessel that it cannot be told
};

OtherLines tell_apart(const VesselLines& lines, const ViewPicture& kept) {
  constexpr double kBothSides = 0.5;
  OtherLines others;
  others.vessels.lines = others.edges.lines = lines;
  for (const std::vector<std::size_t>& piece : pieces_of(lines)) {
    const KnownFalls known(lines, piece, kept);
    for (const std::size_t i : piece) {
      const bool is_edge =
          known.empty() || known.around(int(i) % lines.columns, int(i) / lines.columns,
                                        double(lines.radius[i])) < kBothSides;
      (is_edge ? others.vessels : others.edges).lines.radius[i] = 0.0F;
    }
  }
  for (ViewPicture* kind : {&others.vessels, &others.edges}) {
    leave_out_short(kind->lines);
    find_nearest(*kind);
  }
  return others;
}

/// Whether a pixel is within some radii and two pixels of a line.
bool is_within(const ViewPicture& picture, std::size_t pixel, float radii) {
  constexpr float kPixels = 2.0F;
  const int line = picture.nearest[pixel];
  return line >= 0 &&
         picture.distance[pixel] <= radii * picture.lines.radius[std::size_t(line)] + kPixels;
}

/// The lines without those of the kept vessel: its own, and those that lie wholly beside it, where
/// it is seen broader. One that leaves it is another's from where it does.
VesselLines without_kept(const VesselLines& all, const ViewPicture& kept) {
  constexpr float kOwnRadii = 0.7F, kBesideRadii = 1.33F, kBesidePixels = 2.0F;
  const auto is_near = [&](std::size_t i, float radii) {
    return kept.nearest[i] >= 0 &&
           kept.distance[i] <= std::max(kBesidePixels, radii * all.radius[i]);
  };
  VesselLines lines = all;
  for (std::size_t i = 0; i < all.radius.size(); ++i)
    if (is_near(i, kOwnRadii)) lines.radius[i] = 0.0F;
  for (const std::vector<std::size_t>& piece : pieces_of(lines))
    if (std::all_of(piece.begin(), piece.end(),
                    [&](std::size_t i) { return is_near(i, kBesideRadii); }))
      for (const std::size_t i : piece) lines.radius[i] = 0.0F;
  return lines;
}

}  // namespace

void keep_vessel(ViewPicture& view, const VesselEnds& ends) {
  const auto pixel_at = [&](const std::array<double, 2>& place) {
    const int c = std::clamp(int(std::lround(place[0])), 0, view.lines.columns - 1),
              r = std::clamp(int(std::lround(place[1])), 0, view.lines.rows - 1);
    return r * view.lines.columns + c;
  };
  const std::vector<int> path = cheapest_path(view, pixel_at(ends.proximal), pixel_at(ends.distal));
  constexpr std::ptrdiff_t kBeside = 5;
  std::vector<float> radius(view.lines.radius.size(), 0.0F);
  for (std::ptrdiff_t n = 0; n < std::ptrdiff_t(path.size()); ++n) {
    std::vector<double> near;
    for (std::ptrdiff_t m = std::max<std::ptrdiff_t>(0, n - kBeside);
         m <= std::min(std::ptrdiff_t(path.size()) - 1, n + kBeside); ++m) {
      const int line = view.nearest[std::size_t(path[std::size_t(m)])];
      if (line >= 0) near.push_back(double(view.lines.radius[std::size_t(line)]));
    }
    if (!near.empty()) radius[std::size_t(path[std::size_t(n)])] = float(median(std::move(near)));
  }
  view.lines.radius = std::move(radius);
  find_nearest(view);
}

OtherPixels pixels_of_others(const VesselLines& all, const ViewPicture& kept) {
  constexpr float kCovered = 1.2F, kBackground = 1.6F;
  const OtherLines others = tell_apart(without_kept(all, kept), kept);
  OtherPixels pixels{std::vector<char>(all.radius.size(), 0)};
  double own = 0.0, hidden = 0.0;
  for (std::size_t i = 0; i < pixels.covered.size(); ++i) {
    const bool is_covered =
        is_within(others.vessels, i, kCovered) ||
        (is_within(others.edges, i, kCovered) && !is_within(kept, i, kBackground));
    pixels.covered[i] = is_covered ? 1 : 0;
    const int line = kept.nearest[i];
    if (line < 0 || kept.distance[i] > kept.lines.radius[std::size_t(line)]) continue;
    own += 1.0;
    if (is_covered) hidden += 1.0;
  }
  pixels.hidden_part = own > 0.0 ? hidden / own : 0.0;
  if (pixels.hidden_part > kMostHidden) pixels.covered.clear();
  return pixels;
}

}  // namespace angio::reconstruction::detail

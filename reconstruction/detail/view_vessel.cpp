#include "reconstruction/detail/view_vessel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "core/statistics.hpp"

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

std::vector<char> pixels_of_others(const VesselLines& all, const ViewPicture& kept) {
  constexpr float kBesideRadii = 1.33F, kBesidePixels = 2.0F;
  constexpr float kRadii = 1.2F, kPixels = 2.0F;
  ViewPicture others;
  others.lines = all;
  for (std::size_t i = 0; i < all.radius.size(); ++i)
    if (kept.nearest[i] >= 0 &&
        kept.distance[i] <= std::max(kBesidePixels, kBesideRadii * all.radius[i]))
      others.lines.radius[i] = 0.0F;
  leave_out_short(others.lines);
  find_nearest(others);
  std::vector<char> covered(all.radius.size(), 0);
  for (std::size_t i = 0; i < covered.size(); ++i)
    if (const int line = others.nearest[i]; line >= 0)
      covered[i] =
          others.distance[i] <= kRadii * others.lines.radius[std::size_t(line)] + kPixels ? 1 : 0;
  return covered;
}

}  // namespace angio::reconstruction::detail

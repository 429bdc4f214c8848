#include "reconstruction/detail/view_hull.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>

#include "core/available_memory.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/statistics.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kNearLine = 0.5;    ///< [mm], in the cost
constexpr double kOfRadius = 0.33;   ///< or so much of the radius
constexpr double kRadiiAgree = 4.0;  ///< weight of ln^2 of the radii's ratio
constexpr std::size_t kMostPlaces = 6'000'000;

/// A place as the views see it; cost 0: it cannot be vessel.
struct Seen {
  double cost = 0.0, radius = 0.0;
  std::vector<int> pixel;
};

Seen look(const std::vector<ViewLookup>& views, const Vec3& place, double reach) {
  const std::size_t needed = views.size() < 4 ? views.size() : views.size() - 1;
  Seen seen;
  std::vector<double> radii;
  double cost = 1.0;
  std::size_t missed = 0;
  for (const ViewLookup& view : views) {
    const LineNear near = view.at(place);
    const bool is_near = near.is_seen && near.pixel >= 0 && near.distance_mm <= reach;
    seen.pixel.push_back(is_near ? near.pixel : -1);
    const double away = (is_near ? near.distance_mm : reach) /
                        std::max(kNearLine, is_near ? kOfRadius * near.radius_mm : 0.0);
    cost += away * away;
    if (is_near)
      radii.push_back(near.radius_mm);
    else if (views.size() - ++missed < needed)
      return seen;
  }
  const auto [least, most] = std::minmax_element(radii.begin(), radii.end());
  const double ratio = std::log(*most / *least);
  seen.cost = cost + kRadiiAgree * ratio * ratio;
  seen.radius = median(std::move(radii));
  return seen;
}

/// Half the side of a cube around the isocentre that holds what two views or more can see.
double half_side(const std::vector<ViewLookup>& views) {
  constexpr double kAround = 1.25, kLeast = 20.0, kMost = 200.0;
  double half = kLeast;
  for (const ViewLookup& lookup : views) {
    const ViewPicture& view = lookup.picture();
    const double zoom = angiogram::ConeBeamView(view.frame).see(Vec3{0.0, 0.0, 0.0}).depth;
    half = std::max(half, kAround * 0.5 * zoom *
                              std::max(view.frame.columns * norm(view.frame.column_step),
                                       view.frame.rows * norm(view.frame.row_step)));
  }
  return std::min(half, kMost);
}

/// The places of one layer of the grid, in its order.
struct Layer {
  std::vector<std::array<int, 3>> cell;
  std::vector<float> cost, radius;
  std::vector<int> pixel;
};

Layer look_at_layer(const std::vector<ViewLookup>& views, const Hull& hull, int side, int k,
                    double reach) {
  Layer layer;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const Seen seen =
          look(views, hull.corner + hull.step * Vec3{double(i), double(j), double(k)}, reach);
      if (!(seen.cost > 0.0)) continue;
      layer.cell.push_back({i, j, k});
      layer.cost.push_back(float(seen.cost));
      layer.radius.push_back(float(seen.radius));
      layer.pixel.insert(layer.pixel.end(), seen.pixel.begin(), seen.pixel.end());
    }
  return layer;
}

/// Where rows of cells begin: the first place of each (j, k), and the end.
std::vector<int> row_starts(const Hull& hull, int side) {
  std::vector<int> starts(std::size_t(side) * std::size_t(side) + 1, 0);
  for (const auto& c : hull.cell)
    ++starts[std::size_t(c[2]) * std::size_t(side) + std::size_t(c[1]) + 1];
  for (std::size_t n = 1; n < starts.size(); ++n) starts[n] += starts[n - 1];
  return starts;
}

void find_steps(Hull& hull, int side) {
  const std::vector<int> starts = row_starts(hull, side);
  const auto beside = [&](int i, int j, int k) {
    if (j < 0 || k < 0 || j >= side || k >= side) return -1;
    const std::size_t row = std::size_t(k) * std::size_t(side) + std::size_t(j);
    const auto begin = hull.cell.begin() + starts[row], end = hull.cell.begin() + starts[row + 1];
    const auto found = std::lower_bound(
        begin, end, i, [](const std::array<int, 3>& c, int column) { return c[0] < column; });
    return found != end && (*found)[0] == i ? int(found - hull.cell.begin()) : -1;
  };
  for (int here = 0; here < int(hull.cell.size()); ++here) {
    hull.first_step.push_back(hull.steps.size());
    const auto& c = hull.cell[std::size_t(here)];
    for (int dk = -1; dk <= 1; ++dk)
      for (int dj = -1; dj <= 1; ++dj)
        for (int di = -1; di <= 1; ++di) {
          const int next = beside(c[0] + di, c[1] + dj, c[2] + dk);
          if (next < 0 || next == here) continue;
          hull.steps.push_back(
              {next, float(hull.step * std::sqrt(double(di * di + dj * dj + dk * dk))) * 0.5F *
                         (hull.cost[std::size_t(here)] + hull.cost[std::size_t(next)])});
        }
  }
  hull.first_step.push_back(hull.steps.size());
}

/// Of a place: its own numbers, up to 26 ways, and what a growth over it holds.
std::uint64_t bytes_of_place(std::size_t view_count) {
  constexpr std::uint64_t kOwn = 28, kWays = 26 * sizeof(HullStep), kGrowth = 8;
  return kOwn + kWays + kGrowth + view_count * (sizeof(int) + sizeof(float));
}

void require_memory(std::size_t places, std::size_t view_count, std::uint64_t most_bytes,
                    Wanted wanted) {
  const std::uint64_t needed = places * bytes_of_place(view_count);
  if (needed > most_bytes)
    throw InputError(fmt::format(
        "the places that all views show as vessel need more than {:.2f} GiB of memory, "
        "but {:.2f} GiB are allowed or free. Allow more with --max-memory{}",
        double(needed) / kBytesPerGibibyte, double(most_bytes) / kBytesPerGibibyte,
        wanted == Wanted::all_vessels ? ", or name the one vessel that is wanted with --ends"
                                      : ""));
}

}  // namespace

Hull find_hull(const std::vector<ViewLookup>& views, double reach, std::uint64_t most_bytes,
               Wanted wanted, const Progress& progress) {
  constexpr double kCellsAcross = 320.0;
  constexpr int kLayersAtATime = 16;
  Hull hull;
  const double half = half_side(views);
  hull.step = std::max(0.5, 2.0 * half / kCellsAcross);
  const int side = int(std::ceil(2.0 * half / hull.step)) + 1;
  hull.corner = -half * Vec3{1.0, 1.0, 1.0};
  reach = std::max(reach, 2.0 * hull.step);
  for (int first = 0; first < side; first += kLayersAtATime) {
    progress.report(double(first) / side, "looking for places that all views show as vessel");
    std::vector<Layer> layers(std::size_t(std::min(kLayersAtATime, side - first)));
    parallel_for_uneven(std::ptrdiff_t(layers.size()), [&](std::ptrdiff_t n) {
      layers[std::size_t(n)] = look_at_layer(views, hull, side, first + int(n), reach);
    });
    for (const Layer& layer : layers) {
      hull.cell.insert(hull.cell.end(), layer.cell.begin(), layer.cell.end());
      hull.cost.insert(hull.cost.end(), layer.cost.begin(), layer.cost.end());
      hull.radius.insert(hull.radius.end(), layer.radius.begin(), layer.radius.end());
      hull.pixel.insert(hull.pixel.end(), layer.pixel.begin(), layer.pixel.end());
    }
    require_memory(hull.cell.size(), views.size(), most_bytes, wanted);
    if (hull.cell.size() > kMostPlaces)
      throw InputError(
          "the views show lines everywhere (they are noisy, or not of vessels): too many places "
          "could be vessel. Give views with the vessels filled, or fewer structures around");
  }
  find_steps(hull, side);
  return hull;
}

int nearest_place(const Hull& hull, const std::vector<ViewLookup>& views,
                  const std::vector<std::array<double, 2>>& pixels) {
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int place = 0; place < int(hull.cell.size()); ++place) {
    double away = 0.0;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const angiogram::SeenPoint seen = views[v].see(hull.at(place));
      away += views[v].pixel_mm(seen.depth) *
              std::hypot(seen.column - pixels[v][0], seen.row - pixels[v][1]);
    }
    if (away < least) {
      least = away;
      best = place;
    }
  }
  return best;
}

std::vector<int> cheapest_way(const Hull& hull, int start, int end) {
  std::vector<float> cost(hull.cell.size(), std::numeric_limits<float>::infinity());
  std::vector<int> from(hull.cell.size(), -1);
  using Entry = std::pair<float, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  cost[std::size_t(start)] = 0.0F;
  queue.emplace(0.0F, start);
  while (!queue.empty()) {
    const float so_far = queue.top().first;
    const int here = queue.top().second;
    queue.pop();
    if (here == end) break;
    if (so_far > cost[std::size_t(here)]) continue;
    hull.for_each_neighbour(here, [&](int next, float way) {
      if (so_far + way >= cost[std::size_t(next)]) return;
      cost[std::size_t(next)] = so_far + way;
      from[std::size_t(next)] = here;
      queue.emplace(so_far + way, next);
    });
  }
  std::vector<int> way;
  if (end != start && from[std::size_t(end)] < 0) return way;
  for (int at = end; at >= 0; at = from[std::size_t(at)]) way.push_back(at);
  std::reverse(way.begin(), way.end());
  return way;
}

}  // namespace angio::reconstruction::detail

#include "reconstruction/detail/tree_growth.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_map>
#include <utility>

#include "core/statistics.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kLeastBranch = 3.0;  ///< [mm]
constexpr double kLeastRadii = 1.25;
constexpr int kMostBranches = 20;
constexpr int kRoots = 3;

double second_largest(std::vector<double> values) {
  std::sort(values.begin(), values.end(), std::greater<>());
  return values.size() > 1 ? values[1] : 0.0;
}

/// What a branch must explain of its own [mm].
double least_of_own(double radius) { return std::max(kLeastBranch, kLeastRadii * radius); }

/// How the tree goes on.
struct Growth {
  std::vector<int> places;  ///< away from the tree, the first one is the tree's
  double gain = 0.0;
};

/// The path that explains the most, by Dijkstra from all of the tree.
Growth best_growth(const Hull& hull, const std::vector<ViewLookup>& views,
                   const Explained& explained, const Grown& grown) {
  constexpr double kPerCost = 0.15;  // what a mm of vessel costs where all views agree
  const std::size_t n = hull.cell.size(), view_count = views.size();
  std::vector<float> distance(n, std::numeric_limits<float>::infinity());
  std::vector<int> from(n, -1);
  std::vector<float> gains(n * view_count, 0.0F);
  using Entry = std::pair<float, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const int place : grown.place) {
    distance[std::size_t(place)] = 0.0F;
    queue.emplace(0.0F, place);
  }
  Growth best;
  int best_end = -1;
  std::vector<double> gain(view_count);
  while (!queue.empty()) {
    const float d = queue.top().first;
    const int here = queue.top().second;
    queue.pop();
    if (d > distance[std::size_t(here)]) continue;
    const Vec3 at = hull.at(here);
    if (const int before = from[std::size_t(here)]; before >= 0) {
      const Vec3 was = hull.at(before);
      for (std::size_t v = 0; v < view_count; ++v) {
        float g = gains[std::size_t(before) * view_count + v];
        const int pixel = hull.pixel[std::size_t(here) * view_count + v];
        if (pixel >= 0 && !explained.is(v, pixel)) {
          const auto a = views[v].see(was), b = views[v].see(at);
          g += float(views[v].pixel_mm(b.depth) * std::hypot(b.column - a.column, b.row - a.row));
        }
        gains[std::size_t(here) * view_count + v] = g;
        gain[v] = double(g);
      }
      const double total = second_largest(gain) - kPerCost * double(d);
      if (total > best.gain) {
        best.gain = total;
        best_end = here;
      }
    }
    hull.for_each_neighbour(here, [&](int next, float way) {
      if (d + way >= distance[std::size_t(next)]) return;
      distance[std::size_t(next)] = d + way;
      from[std::size_t(next)] = here;
      queue.emplace(d + way, next);
    });
  }
  for (int at = best_end; at >= 0; at = from[std::size_t(at)]) best.places.push_back(at);
  std::reverse(best.places.begin(), best.places.end());
  return best;
}

/// @param index_of  of places that are in the tree already
void add(const Hull& hull, const Growth& growth, Grown& grown,
         std::unordered_map<int, int>& index_of, Explained& explained) {
  int before = index_of.at(growth.places.front());
  for (std::size_t n = 1; n < growth.places.size(); ++n) {
    const int place = growth.places[n];
    grown.place.push_back(place);
    grown.from.push_back(before);
    before = int(grown.place.size()) - 1;
    index_of.emplace(place, before);
    explained.mark(hull.at(place), double(hull.radius[std::size_t(place)]), hull.step);
  }
}

Grown grow(const Hull& hull, const std::vector<ViewLookup>& views, int root,
           const Progress& progress) {
  Grown grown{{root}, {-1}};
  std::unordered_map<int, int> index_of{{root, 0}};
  Explained explained(views);
  explained.mark(hull.at(root), double(hull.radius[std::size_t(root)]), hull.step);
  for (int branch = 0; branch < kMostBranches; ++branch) {
    progress.report(double(branch) / kMostBranches, "growing the tree");
    const Growth growth = best_growth(hull, views, explained, grown);
    if (growth.places.size() < 2) break;
    std::vector<double> radii;
    for (const int place : growth.places) radii.push_back(double(hull.radius[std::size_t(place)]));
    const double radius = median(std::move(radii));
    if (growth.gain < least_of_own(radius)) break;
    add(hull, growth, grown, index_of, explained);
  }
  for (const double part : explained.parts()) grown.explained += part;
  return grown;
}

/// Where the vessels are the widest, and all views agree; far from each other.
std::vector<int> roots(const Hull& hull) {
  constexpr double kApart = 15.0, kSureCost = 2.0;
  std::vector<int> order;
  for (std::size_t n = 0; n < hull.cell.size(); ++n)
    if (double(hull.cost[n]) < kSureCost) order.push_back(int(n));
  if (order.empty()) {
    const auto least = std::min_element(hull.cost.begin(), hull.cost.end());
    if (least != hull.cost.end()) order.push_back(int(least - hull.cost.begin()));
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return hull.radius[std::size_t(a)] > hull.radius[std::size_t(b)];
  });
  std::vector<int> chosen;
  for (const int place : order) {
    if (int(chosen.size()) == kRoots) break;
    if (std::all_of(chosen.begin(), chosen.end(),
                    [&](int other) { return distance(hull.at(place), hull.at(other)) > kApart; }))
      chosen.push_back(place);
  }
  return chosen;
}

/// Takes out leaves that explain too little that no other stretch does; again until none is left.
void prune(const Hull& hull, const std::vector<ViewLookup>& views, Grown& grown) {
  while (true) {
    const auto neighbours = neighbours_of(grown);
    const std::vector<GrownStretch> stretches = stretches_of(neighbours);
    if (stretches.size() < 2) return;
    int worst = -1;
    double worst_share = 1.0;
    for (std::size_t s = 0; s < stretches.size(); ++s) {
      const GrownStretch& leaf = stretches[s];
      const bool ends_first = neighbours[std::size_t(leaf.first)].size() == 1,
                 ends_last = neighbours[std::size_t(leaf.last)].size() == 1;
      if (!ends_first && !ends_last) continue;
      Explained others(views);
      for (std::size_t o = 0; o < stretches.size(); ++o)
        if (o != s)
          for (const int node : stretches[o].nodes) {
            const int place = grown.place[std::size_t(node)];
            others.mark(hull.at(place), double(hull.radius[std::size_t(place)]), hull.step);
          }
      std::vector<double> own(views.size(), 0.0);
      double radius = 0.0;
      for (std::size_t n = 1; n < leaf.nodes.size(); ++n) {
        const int was = grown.place[std::size_t(leaf.nodes[n - 1])],
                  is = grown.place[std::size_t(leaf.nodes[n])];
        radius += double(hull.radius[std::size_t(is)]) / double(leaf.nodes.size() - 1);
        for (std::size_t v = 0; v < views.size(); ++v) {
          const int pixel = hull.pixel[std::size_t(is) * views.size() + v];
          if (pixel < 0 || others.is(v, pixel)) continue;
          const auto a = views[v].see(hull.at(was)), b = views[v].see(hull.at(is));
          own[v] += views[v].pixel_mm(b.depth) * std::hypot(b.column - a.column, b.row - a.row);
        }
      }
      const double share = second_largest(own) / least_of_own(radius);
      if (share < worst_share) {
        worst_share = share;
        worst = int(s);
      }
    }
    if (worst < 0) return;
    const GrownStretch& leaf = stretches[std::size_t(worst)];
    std::vector<char> goes(grown.place.size(), 0);
    for (const int node : leaf.nodes) goes[std::size_t(node)] = 1;
    // A fork stays where it is.
    if (neighbours[std::size_t(leaf.first)].size() > 1) goes[std::size_t(leaf.first)] = 0;
    if (neighbours[std::size_t(leaf.last)].size() > 1) goes[std::size_t(leaf.last)] = 0;
    Grown kept;
    std::vector<int> index(grown.place.size(), -1);
    // The root may go: edges are laid anew from the first that stays.
    for (std::size_t n = 0; n < grown.place.size(); ++n)
      if (!goes[n]) {
        index[n] = int(kept.place.size());
        kept.place.push_back(grown.place[n]);
        kept.from.push_back(-1);
      }
    for (std::size_t n = 0; n < grown.place.size(); ++n)
      if (!goes[n] && grown.from[n] >= 0 && !goes[std::size_t(grown.from[n])])
        kept.from[std::size_t(index[n])] = index[std::size_t(grown.from[n])];
    grown = std::move(kept);
  }
}

}  // namespace

Explained::Explained(const std::vector<ViewLookup>& views) : views_(views) {
  for (const ViewLookup& view : views)
    is_explained_.emplace_back(view.picture().lines.radius.size(), 0);
}

void Explained::mark(const Vec3& place, double radius, double step) {
  for (std::size_t v = 0; v < views_.size(); ++v) {
    const angiogram::SeenPoint seen = views_[v].see(place);
    if (!(seen.depth > 0.0)) continue;
    const VesselLines& lines = views_[v].picture().lines;
    const double reach =
        std::max(2.0, std::max(0.6 * radius, 1.5 * step) / views_[v].pixel_mm(seen.depth));
    const int r0 = int(std::ceil(seen.row - reach)), r1 = int(std::floor(seen.row + reach));
    const int c0 = int(std::ceil(seen.column - reach)), c1 = int(std::floor(seen.column + reach));
    for (int r = std::max(0, r0); r <= std::min(lines.rows - 1, r1); ++r)
      for (int c = std::max(0, c0); c <= std::min(lines.columns - 1, c1); ++c)
        if (std::hypot(c - seen.column, r - seen.row) <= reach)
          is_explained_[v][std::size_t(r) * std::size_t(lines.columns) + std::size_t(c)] = 1;
  }
}

std::vector<double> Explained::parts() const {
  std::vector<double> parts;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    const VesselLines& lines = views_[v].picture().lines;
    double all = 0.0, explained = 0.0;
    for (std::size_t i = 0; i < lines.radius.size(); ++i)
      if (lines.radius[i] > 0.0F) {
        all += 1.0;
        explained += is_explained_[v][i] ? 1.0 : 0.0;
      }
    parts.push_back(all > 0.0 ? explained / all : 0.0);
  }
  return parts;
}

std::vector<std::vector<int>> neighbours_of(const Grown& grown) {
  std::vector<std::vector<int>> neighbours(grown.place.size());
  for (std::size_t n = 0; n < grown.from.size(); ++n)
    if (grown.from[n] >= 0) {
      neighbours[n].push_back(grown.from[n]);
      neighbours[std::size_t(grown.from[n])].push_back(int(n));
    }
  return neighbours;
}

std::vector<GrownStretch> stretches_of(const std::vector<std::vector<int>>& neighbours) {
  std::vector<GrownStretch> all;
  for (int n = 0; n < int(neighbours.size()); ++n) {
    if (neighbours[std::size_t(n)].size() == 2 || neighbours[std::size_t(n)].empty()) continue;
    for (int next : neighbours[std::size_t(n)]) {
      GrownStretch stretch{n, n, {n}};
      int before = n;
      while (true) {
        stretch.nodes.push_back(next);
        const auto& around = neighbours[std::size_t(next)];
        if (around.size() != 2) break;
        const int after = around[0] == before ? around[1] : around[0];
        before = next;
        next = after;
      }
      stretch.last = next;
      if (stretch.first < stretch.last) all.push_back(std::move(stretch));
    }
  }
  return all;
}

Grown grow_tree(const Hull& hull, const std::vector<ViewLookup>& views, const Progress& progress) {
  Grown best;
  const std::vector<int> starts = roots(hull);
  for (std::size_t s = 0; s < starts.size(); ++s) {
    const auto share = [&](std::size_t n) { return double(n) / double(starts.size()); };
    Grown grown = grow(hull, views, starts[s], part(progress, share(s), share(s + 1)));
    if (best.place.empty() || grown.explained > best.explained) best = std::move(grown);
  }
  if (best.place.size() > 1) prune(hull, views, best);
  return best;
}

}  // namespace angio::reconstruction::detail

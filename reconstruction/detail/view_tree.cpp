#include "reconstruction/detail/view_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <queue>
#include <unordered_map>
#include <utility>

#include "core/error.hpp"
#include "core/statistics.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kNearLine = 0.5;     ///< [mm], in the cost
constexpr double kOfRadius = 0.33;    ///< or so much of the radius
constexpr double kReach = 2.0;        ///< of a place from a view's line [mm]
constexpr double kRadiiAgree = 4.0;   ///< weight of ln^2 of the radii's ratio
constexpr double kLeastBranch = 3.0;  ///< [mm]
constexpr double kLeastRadii = 1.25;
constexpr int kMostBranches = 20;
constexpr int kRoots = 3;
constexpr std::size_t kMostPlaces = 6'000'000;

/// Places of a grid that may be vessel.
struct Hull {
  double step = 0.5;  ///< [mm]
  Vec3 corner;
  std::array<int, 3> size{};
  std::vector<std::array<int, 3>> cell;
  std::vector<float> cost;    ///< a mm
  std::vector<float> radius;  ///< the views' median [mm]
  std::vector<int> pixel;     ///< nearest line, shape [places, views]; -1: too far
  std::unordered_map<std::int64_t, int> place_of;

  [[nodiscard]] Vec3 at(int place) const {
    const auto& c = cell[std::size_t(place)];
    return corner + step * Vec3{double(c[0]), double(c[1]), double(c[2])};
  }
  [[nodiscard]] std::int64_t key(int i, int j, int k) const {
    return (std::int64_t(k) * size[1] + j) * size[0] + i;
  }
  [[nodiscard]] int find(int i, int j, int k) const {
    if (i < 0 || j < 0 || k < 0 || i >= size[0] || j >= size[1] || k >= size[2]) return -1;
    const auto found = place_of.find(key(i, j, k));
    return found == place_of.end() ? -1 : found->second;
  }
};

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
double half_side(const std::vector<ViewPicture>& views) {
  constexpr double kAround = 1.25, kLeast = 20.0, kMost = 200.0;
  double half = kLeast;
  for (const ViewPicture& view : views) {
    const double zoom = angiogram::ConeBeamView(view.frame).see(Vec3{0.0, 0.0, 0.0}).depth;
    half = std::max(half, kAround * 0.5 * zoom *
                              std::max(view.frame.columns * norm(view.frame.column_step),
                                       view.frame.rows * norm(view.frame.row_step)));
  }
  return std::min(half, kMost);
}

Hull find_hull(const std::vector<ViewPicture>& views, const std::vector<ViewLookup>& lookups,
               double reach) {
  Hull hull;
  const double half = half_side(views);
  constexpr double kCellsAcross = 320.0;
  hull.step = std::max(0.5, 2.0 * half / kCellsAcross);
  const int side = int(std::ceil(2.0 * half / hull.step)) + 1;
  hull.size = {side, side, side};
  hull.corner = -half * Vec3{1.0, 1.0, 1.0};
  reach = std::max(reach, 2.0 * hull.step);
  for (int k = 0; k < side; ++k)
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) {
        Seen seen =
            look(lookups, hull.corner + hull.step * Vec3{double(i), double(j), double(k)}, reach);
        if (!(seen.cost > 0.0)) continue;
        hull.place_of.emplace(hull.key(i, j, k), int(hull.cell.size()));
        hull.cell.push_back({i, j, k});
        hull.cost.push_back(float(seen.cost));
        hull.radius.push_back(float(seen.radius));
        hull.pixel.insert(hull.pixel.end(), seen.pixel.begin(), seen.pixel.end());
        if (hull.cell.size() > kMostPlaces)
          throw InputError(
              "the views show lines everywhere (they are noisy, or not of vessels): too many "
              "places "
              "could be vessel. Give views with the vessels filled, or fewer structures around");
      }
  return hull;
}

/// What of each view's lines is accounted for.
class Explained {
 public:
  explicit Explained(const std::vector<ViewLookup>& views) : views_(views) {
    for (const ViewLookup& view : views)
      is_explained_.emplace_back(view.picture().lines.radius.size(), 0);
  }
  [[nodiscard]] bool is(std::size_t view, int pixel) const {
    return is_explained_[view][std::size_t(pixel)] != 0;
  }
  /// By a vessel through a place.
  void mark(const Vec3& place, double radius, double step) {
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
  /// Part of each view's lines.
  [[nodiscard]] std::vector<double> parts() const {
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

 private:
  const std::vector<ViewLookup>& views_;
  std::vector<std::vector<std::uint8_t>> is_explained_;
};

double second_largest(std::vector<double> values) {
  std::sort(values.begin(), values.end(), std::greater<>());
  return values.size() > 1 ? values[1] : 0.0;
}

/// What a branch must explain of its own [mm].
double least_of_own(double radius) { return std::max(kLeastBranch, kLeastRadii * radius); }

/// A tree of places: each has one from which it was reached, the root none.
struct Grown {
  std::vector<int> place;  ///< of the hull, in the order of growth
  std::vector<int> from;   ///< index here, -1: the root
  double explained = 0.0;  ///< parts of the views' lines, summed
};

/// @param visit  with the place beside, and the cost of the way to it
template <typename Visit>
void for_each_neighbour(const Hull& hull, int here, const Visit& visit) {
  const auto& c = hull.cell[std::size_t(here)];
  for (int dk = -1; dk <= 1; ++dk)
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di) {
        const int next = hull.find(c[0] + di, c[1] + dj, c[2] + dk);
        if (next < 0 || next == here) continue;
        visit(next, float(hull.step * std::sqrt(double(di * di + dj * dj + dk * dk))) * 0.5F *
                        (hull.cost[std::size_t(here)] + hull.cost[std::size_t(next)]));
      }
}

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
    for_each_neighbour(hull, here, [&](int next, float way) {
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

Grown grow(const Hull& hull, const std::vector<ViewLookup>& views, int root, int most_branches) {
  Grown grown{{root}, {-1}};
  std::unordered_map<int, int> index_of{{root, 0}};
  Explained explained(views);
  explained.mark(hull.at(root), double(hull.radius[std::size_t(root)]), hull.step);
  for (int branch = 0; branch < most_branches; ++branch) {
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

/// A stretch between two ends or forks: its places, both ends included.
struct Stretch {
  int first = 0, last = 0;  ///< nodes
  std::vector<int> nodes;
};

std::vector<std::vector<int>> neighbours_of(const Grown& grown) {
  std::vector<std::vector<int>> neighbours(grown.place.size());
  for (std::size_t n = 0; n < grown.from.size(); ++n)
    if (grown.from[n] >= 0) {
      neighbours[n].push_back(grown.from[n]);
      neighbours[std::size_t(grown.from[n])].push_back(int(n));
    }
  return neighbours;
}

std::vector<Stretch> stretches_of(const std::vector<std::vector<int>>& neighbours) {
  std::vector<Stretch> all;
  for (int n = 0; n < int(neighbours.size()); ++n) {
    if (neighbours[std::size_t(n)].size() == 2 || neighbours[std::size_t(n)].empty()) continue;
    for (int next : neighbours[std::size_t(n)]) {
      Stretch stretch{n, n, {n}};
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

/// Takes out leaves that explain too little that no other stretch does; again until none is left.
void prune(const Hull& hull, const std::vector<ViewLookup>& views, Grown& grown) {
  while (true) {
    const auto neighbours = neighbours_of(grown);
    const std::vector<Stretch> stretches = stretches_of(neighbours);
    if (stretches.size() < 2) return;
    int worst = -1;
    double worst_share = 1.0;
    for (std::size_t s = 0; s < stretches.size(); ++s) {
      const Stretch& leaf = stretches[s];
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
    const Stretch& leaf = stretches[std::size_t(worst)];
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

/// Blurred along itself, both ends held.
void smooth(std::vector<Vec3>& points, std::vector<double>& radii, double step) {
  constexpr double kBlur = 2.0;  // [mm]
  const int rounds = std::max(1, int(std::lround(2.0 * kBlur * kBlur / (step * step))));
  for (int round = 0; round < rounds; ++round) {
    const std::vector<Vec3> was = points;
    const std::vector<double> were = radii;
    for (std::size_t n = 1; n + 1 < points.size(); ++n) {
      points[n] = 0.25 * was[n - 1] + 0.5 * was[n] + 0.25 * was[n + 1];
      radii[n] = 0.25 * were[n - 1] + 0.5 * were[n] + 0.25 * were[n + 1];
    }
  }
}

/// Points and radii of each node, smooth along each stretch.
struct SmoothTree {
  std::vector<Vec3> point;
  std::vector<double> radius;
};

SmoothTree smooth_tree(const Hull& hull, const Grown& grown,
                       const std::vector<Stretch>& stretches) {
  SmoothTree tree;
  for (const int place : grown.place) {
    tree.point.push_back(hull.at(place));
    tree.radius.push_back(double(hull.radius[std::size_t(place)]));
  }
  for (const Stretch& stretch : stretches) {
    std::vector<Vec3> points;
    std::vector<double> radii;
    for (const int node : stretch.nodes) {
      points.push_back(tree.point[std::size_t(node)]);
      radii.push_back(tree.radius[std::size_t(node)]);
    }
    smooth(points, radii, hull.step);
    for (std::size_t n = 1; n + 1 < stretch.nodes.size(); ++n) {
      tree.point[std::size_t(stretch.nodes[n])] = points[n];
      tree.radius[std::size_t(stretch.nodes[n])] = radii[n];
    }
  }
  return tree;
}

/// The end whose vessel is the widest, over 5 mm from it.
int widest_end(const std::vector<std::vector<int>>& neighbours, const std::vector<Stretch>& all,
               const SmoothTree& tree) {
  constexpr double kNear = 5.0;
  int best = -1;
  double widest = 0.0;
  for (const Stretch& stretch : all)
    for (const bool from_first : {true, false}) {
      const int end = from_first ? stretch.first : stretch.last;
      if (neighbours[std::size_t(end)].size() != 1) continue;
      std::vector<double> radii;
      double along = 0.0;
      for (std::size_t n = 0; n < stretch.nodes.size() && along < kNear; ++n) {
        const auto node = [&](std::size_t m) {
          return std::size_t(stretch.nodes[from_first ? m : stretch.nodes.size() - 1 - m]);
        };
        radii.push_back(tree.radius[node(n)]);
        if (n + 1 < stretch.nodes.size())
          along += distance(tree.point[node(n)], tree.point[node(n + 1)]);
      }
      const double radius = median(std::move(radii));
      if (radius > widest) {
        widest = radius;
        best = end;
      }
    }
  return best;
}

/// One path from the inlet to each other end, the longest first.
CenterlineTree paths_from(int inlet, const std::vector<std::vector<int>>& neighbours,
                          const SmoothTree& smooth_places) {
  std::vector<int> before(neighbours.size(), -2), order{inlet};
  before[std::size_t(inlet)] = -1;
  for (std::size_t n = 0; n < order.size(); ++n)
    for (const int next : neighbours[std::size_t(order[n])])
      if (before[std::size_t(next)] == -2) {
        before[std::size_t(next)] = order[n];
        order.push_back(next);
      }
  CenterlineTree tree;
  for (const int end : order) {
    if (end == inlet || neighbours[std::size_t(end)].size() != 1) continue;
    CenterlinePath path;
    for (int at = end; at >= 0; at = before[std::size_t(at)]) {
      path.points.push_back(smooth_places.point[std::size_t(at)]);
      path.inscribed_radius.push_back(smooth_places.radius[std::size_t(at)]);
    }
    std::reverse(path.points.begin(), path.points.end());
    std::reverse(path.inscribed_radius.begin(), path.inscribed_radius.end());
    path.abscissa = arc_length(path.points);
    tree.paths.push_back(std::move(path));
  }
  std::stable_sort(tree.paths.begin(), tree.paths.end(),
                   [](const CenterlinePath& a, const CenterlinePath& b) {
                     return a.abscissa.back() > b.abscissa.back();
                   });
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    tree.paths[p].id = int(p);
    tree.paths[p].tracts = {{0, int(tree.paths[p].points.size()) - 1, int(p), 0, false}};
  }
  return tree;
}

/// The place that the views see nearest to a pixel in each; sum of the distances [mm].
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

/// Places from one to another at the least cost; empty: there is no way.
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
    for_each_neighbour(hull, here, [&](int next, float way) {
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

std::vector<ViewLookup> lookups_of(const std::vector<ViewPicture>& views) {
  std::vector<ViewLookup> lookups;
  for (const ViewPicture& view : views) lookups.emplace_back(view);
  return lookups;
}

/// The tree of places as smooth lines, and what they explain.
/// @param inlet  node, -1: the widest end
ViewTree to_tree(const Hull& hull, const std::vector<ViewLookup>& lookups, const Grown& grown,
                 int inlet) {
  ViewTree result;
  const auto neighbours = neighbours_of(grown);
  const std::vector<Stretch> stretches = stretches_of(neighbours);
  Explained explained(lookups);
  for (const int place : grown.place)
    explained.mark(hull.at(place), double(hull.radius[std::size_t(place)]), hull.step);
  result.explained_parts = explained.parts();
  if (stretches.empty()) return result;
  const SmoothTree smooth_places = smooth_tree(hull, grown, stretches);
  result.tree = paths_from(inlet >= 0 ? inlet : widest_end(neighbours, stretches, smooth_places),
                           neighbours, smooth_places);
  return result;
}

}  // namespace

ViewTree find_view_tree(const std::vector<ViewPicture>& views, const Progress& progress) {
  ANGIO_EXPECT(views.size() >= 2);
  const std::vector<ViewLookup> lookups = lookups_of(views);
  progress.report(0.0, "looking for places that all views show as vessel");
  const Hull hull = find_hull(views, lookups, kReach);
  Grown best;
  const std::vector<int> starts = roots(hull);
  for (std::size_t s = 0; s < starts.size(); ++s) {
    progress.report(0.2 + 0.6 * double(s) / double(starts.size()), "growing the tree");
    Grown grown = grow(hull, lookups, starts[s], kMostBranches);
    if (best.place.empty() || grown.explained > best.explained) best = std::move(grown);
  }
  if (best.place.size() > 1) prune(hull, lookups, best);
  return to_tree(hull, lookups, best, -1);
}

ViewTree find_view_vessel(const std::vector<ViewPicture>& views,
                          const std::vector<VesselEnds>& ends) {
  ANGIO_EXPECT(views.size() >= 2 && ends.size() == views.size());
  constexpr double kFarthest = 8.0;
  const std::vector<ViewLookup> lookups = lookups_of(views);
  std::vector<std::array<double, 2>> proximal, distal;
  for (const VesselEnds& one : ends) {
    proximal.push_back(one.proximal);
    distal.push_back(one.distal);
  }
  for (double reach = kReach; reach <= kFarthest; reach *= 2.0) {
    const Hull hull = find_hull(views, lookups, reach);
    if (hull.cell.empty()) continue;
    Grown grown;
    grown.place = cheapest_way(hull, nearest_place(hull, lookups, proximal),
                               nearest_place(hull, lookups, distal));
    if (grown.place.size() < 2) continue;
    for (std::size_t n = 0; n < grown.place.size(); ++n) grown.from.push_back(int(n) - 1);
    return to_tree(hull, lookups, grown, 0);
  }
  return {};
}

}  // namespace angio::reconstruction::detail

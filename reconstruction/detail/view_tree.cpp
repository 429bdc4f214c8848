#include "reconstruction/detail/view_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "core/error.hpp"
#include "core/statistics.hpp"
#include "reconstruction/detail/tree_growth.hpp"
#include "reconstruction/detail/view_by_view.hpp"
#include "reconstruction/detail/view_hull.hpp"

namespace angio::reconstruction::detail {
namespace {

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
                       const std::vector<GrownStretch>& stretches) {
  SmoothTree tree;
  for (const int place : grown.place) {
    tree.point.push_back(hull.at(place));
    tree.radius.push_back(double(hull.radius[std::size_t(place)]));
  }
  for (const GrownStretch& stretch : stretches) {
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
int widest_end(const std::vector<std::vector<int>>& neighbours,
               const std::vector<GrownStretch>& all, const SmoothTree& tree) {
  constexpr double kNear = 5.0;
  int best = -1;
  double widest = 0.0;
  for (const GrownStretch& stretch : all)
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

std::vector<ViewLookup> lookups_of(const std::vector<ViewPicture>& views) {
  std::vector<ViewLookup> lookups;
  for (const ViewPicture& view : views) lookups.emplace_back(view);
  return lookups;
}

std::vector<ViewPicture> posed_views(std::vector<ViewPicture> views,
                                     const std::vector<ViewPose>& poses) {
  for (std::size_t v = 0; v < views.size(); ++v) views[v].frame = posed(views[v].frame, poses[v]);
  return views;
}

/// The tree of places as smooth lines, and what they explain.
/// @param inlet  node, -1: the widest end
ViewTree to_tree(const Hull& hull, const std::vector<ViewLookup>& lookups, const Grown& grown,
                 int inlet) {
  ViewTree result;
  const auto neighbours = neighbours_of(grown);
  const std::vector<GrownStretch> stretches = stretches_of(neighbours);
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

ViewTree find_view_tree(const std::vector<ViewPicture>& views, std::uint64_t most_bytes,
                        const Progress& progress) {
  ANGIO_EXPECT(views.size() >= 2);
  const std::vector<ViewLookup> lookups = lookups_of(views);
  const Hull hull =
      find_hull(lookups, kHullReach, most_bytes, Wanted::all_vessels, part(progress, 0.0, 0.3));
  return to_tree(hull, lookups, grow_tree(hull, lookups, part(progress, 0.3, 1.0)), -1);
}

PosedTree find_posed_tree(const std::vector<ViewPicture>& views, std::uint64_t most_bytes,
                          const Progress& progress) {
  constexpr int kMostRounds = 4;
  constexpr double kWorthIt = 0.01;
  constexpr double kLineError = 1.0;  // [pixels]; rays that pass nearer contradict nothing
  const auto tree_of = [&](const std::vector<ViewPicture>& seen, int round) {
    return find_view_tree(
        seen, most_bytes,
        part(progress, double(round) / kMostRounds, double(round + 1) / kMostRounds));
  };
  const auto explained = [](const ViewTree& tree) {
    return std::accumulate(tree.explained_parts.begin(), tree.explained_parts.end(), 0.0);
  };
  PosedTree best{tree_of(views, 0), std::vector<ViewPose>(views.size())};
  const auto loses_a_view = [&](const ViewTree& tree) {
    constexpr double kLoss = 0.95;
    for (std::size_t v = 0; v < views.size(); ++v)
      if (tree.explained_parts[v] < kLoss * best.found.explained_parts[v]) return true;
    return false;
  };
  std::vector<angiogram::ConeBeamFrame> frames;
  for (const ViewPicture& view : views) frames.push_back(view.frame);
  const double pixel = finest_pixel(frames);
  if (views.size() < 3) return best;
  for (int round = 1; round < kMostRounds; ++round) {
    const std::vector<ViewPicture> seen = posed_views(views, best.poses);
    if (view_skew(seen, best.found.tree) < kLineError * pixel) break;
    std::vector<ViewPose> poses = find_view_poses(views, best.found.tree, best.poses);
    ViewTree found;
    try {
      found = tree_of(posed_views(views, poses), round);
    } catch (const InputError&) {  // more places than there is room for: the last tree stays
      break;
    }
    if (explained(found) < (1.0 + kWorthIt) * explained(best.found) || loses_a_view(found)) break;
    best = {std::move(found), std::move(poses)};
  }
  return best;
}

ViewTree find_view_vessel(const std::vector<ViewPicture>& views,
                          const std::vector<VesselEnds>& ends, std::uint64_t most_bytes) {
  ANGIO_EXPECT(views.size() >= 2 && ends.size() == views.size());
  constexpr double kFarthest = 8.0;
  const std::vector<ViewLookup> lookups = lookups_of(views);
  std::vector<std::array<double, 2>> proximal, distal;
  for (const VesselEnds& one : ends) {
    proximal.push_back(one.proximal);
    distal.push_back(one.distal);
  }
  for (double reach = kHullReach; reach <= kFarthest; reach *= 2.0) {
    const Hull hull = find_hull(lookups, reach, most_bytes, Wanted::one_vessel);
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

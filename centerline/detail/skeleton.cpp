#include "centerline/detail/skeleton.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "centerline/detail/fronts.hpp"
#include "core/error.hpp"

namespace angio::centerline {

int end_of_cap(const std::vector<Vec3>& points, const std::vector<double>& depth) {
  // Arc length on the voxel grid zigzags; the straight distance to the tip does not.
  int last_inside = -1;
  double deepest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double a = distance(points[i], points[0]);
    deepest = std::max(deepest, depth[i]);
    if (a > 4.0 * deepest && i > 3) break;
    if (depth[i] >= 0.5 * a) last_inside = int(i);
  }
  return std::min(last_inside + 1, int(points.size()) - 1);
}

namespace {

double voxel_size(const LumenVoxels& lumen) {
  const Vec3 h = lumen.geometry.spacing;
  return std::max({h.x, h.y, h.z});
}

/// Whether a voxel is one of the volume's last.
bool at_border(const LumenVoxels& lumen, int voxel) {
  const auto at = lumen.index(voxel);
  for (std::size_t a = 0; a < 3; ++a)
    if (at[a] + lumen.corner[a] == 0 || at[a] + lumen.corner[a] == lumen.geometry.size[a] - 1)
      return true;
  return false;
}

int farthest(const Front& front) {
  return int(std::max_element(front.length.begin(), front.length.end()) - front.length.begin());
}

struct Ends {
  std::vector<LumenEnd> ends;
  std::vector<LumenEnd> sacs;  ///< stand out like branches, but end without an outlet
  Front front;                 ///< from the source, behind the last cut
  std::vector<int> loop_cuts;  ///< a voxel next to each round's first cut
};

/// Whether a branch is the sac of an aneurysm: wider inside than at its mouth, and beyond its
/// parent's wall not much longer than wide. One that the border of the volume cuts off is a vessel.
/// @param own  the branch's voxels, tip first
/// @param junction  the parent's voxel that it leaves
bool is_sac(const LumenVoxels& lumen, const std::vector<int>& own, int junction) {
  constexpr double kWider = 1.2, kLonger = 1.5;
  if (own.empty() || junction < 0 || at_border(lumen, own.front())) return false;
  double narrowest = 1e300, mouth = 1e300, widest = 0.0, length = 0.0;
  for (std::size_t i = own.size(); i-- > 0;) {
    if (distance(lumen.position(own[i]), lumen.position(junction)) <
        double(lumen.depth[std::size_t(junction)]))
      continue;  // within the parent
    if (i + 1 < own.size()) length += distance(lumen.position(own[i]), lumen.position(own[i + 1]));
    const double depth = double(lumen.depth[std::size_t(own[i])]);
    narrowest = std::min(narrowest, depth);
    if (depth <= widest) continue;
    widest = depth;
    mouth = narrowest;  // the narrowest place before the widest
  }
  return widest > kWider * mouth && length < kLonger * 2.0 * widest;
}

/// Leaves out maxima that are bumps of the wall: a side branch must stand out of its parent by
/// about the parent's diameter.
Ends prune_spurs(const LumenVoxels& lumen, const Front& front, const std::vector<LumenEnd>& maxima,
                 double min_length) {
  Ends result;
  std::vector<char> in_tree(std::size_t(lumen.count()), 0);
  for (const LumenEnd& end : maxima) {
    std::vector<int> own;
    int v = end.voxel;
    for (; v >= 0 && in_tree[std::size_t(v)] == 0; v = front.previous[std::size_t(v)])
      own.push_back(v);
    const double parent = v >= 0 ? double(lumen.depth[std::size_t(v)]) : 0.0;
    const double least =
        min_length > 0.0 ? min_length : std::max(2.0 * parent, 4.0 * voxel_size(lumen));
    if (!result.ends.empty() && end.prominence < least) continue;
    const bool sac = !result.ends.empty() && is_sac(lumen, own, v);
    (sac ? result.sacs : result.ends).push_back(end);
    for (const int w : own) in_tree[std::size_t(w)] = 1;
  }
  return result;
}

/// The ends seen from `source`, spurs left out, loops cut.
/// @param near_cut  1 for the voxels next to a cut so far, shape [voxel]
Ends find_ends(LumenVoxels& lumen, int source, double min_length, std::vector<char>& near_cut) {
  Ends result;
  constexpr int kMostRounds = 6;  // a cut can lay open another loop; more than this is a sponge
  for (int round = 0;; ++round) {
    result.front = march(lumen, source);
    const Front& front = result.front;
    const auto maxima = find_maxima(lumen, front, 2.0 * voxel_size(lumen));
    Ends found = prune_spurs(lumen, front, maxima, min_length);
    result.ends = std::move(found.ends);
    result.sacs = std::move(found.sacs);
    for (LumenEnd& end : result.ends) {
      const double reach = 2.0 * voxel_size(lumen);
      for (int v = end.voxel;
           v >= 0 && distance(lumen.position(v), lumen.position(end.voxel)) <= reach;
           v = front.previous[std::size_t(v)])
        end.at_loop_cut = end.at_loop_cut || near_cut[std::size_t(v)] != 0;
    }
    if (round == kMostRounds) return result;
    std::vector<std::vector<int>> paths;
    for (const auto* some : {&result.ends, &result.sacs})
      for (const LumenEnd& end : *some) paths.push_back(trace(front, end.voxel));
    const std::vector<int> cut = cut_loops(lumen, front, paths);
    if (cut.empty()) return result;
    result.loop_cuts.push_back(cut.front());
    for (const int v : cut) near_cut[std::size_t(v)] = 1;
  }
}

/// How wide the vessel is that ends here: the lower quartile of the depth over six radii past its
/// cap, so that neither a narrow place nor the sac of an aneurysm counts for the vessel. Where the
/// border of the volume cuts the vessel off, it counts by a quarter more: what feeds the lumen
/// mostly comes from outside.
double inlet_score(const LumenVoxels& lumen, const std::vector<int>& tip_first) {
  std::vector<Vec3> points;
  std::vector<double> depth;
  for (const int v : tip_first) {
    points.push_back(lumen.position(v));
    depth.push_back(double(lumen.depth[std::size_t(v)]));
  }
  const auto begin = std::size_t(end_of_cap(points, depth));
  const bool cut_off = std::any_of(tip_first.begin(), tip_first.begin() + std::ptrdiff_t(begin) + 1,
                                   [&](int v) { return at_border(lumen, v); });
  std::vector<double> inside;
  for (std::size_t i = begin; i < points.size(); ++i)
    if (distance(points[i], points[begin]) <= 6.0 * depth[begin]) inside.push_back(depth[i]);
  const auto quartile = inside.begin() + std::ptrdiff_t(inside.size() / 4);
  std::nth_element(inside.begin(), quartile, inside.end());
  return (cut_off ? 1.25 : 1.0) * *quartile;
}

/// @param front  from the root
int widest_end(const LumenVoxels& lumen, int root, const Front& front,
               const std::vector<LumenEnd>& ends) {
  std::vector<int> from_root = trace(front, ends.front().voxel);
  int best = root;
  double best_score = inlet_score(lumen, from_root);
  for (const LumenEnd& end : ends) {
    if (end.at_loop_cut) continue;
    std::vector<int> chain = trace(front, end.voxel);
    std::reverse(chain.begin(), chain.end());
    const double score = inlet_score(lumen, chain);
    if (score <= best_score) continue;
    best_score = score;
    best = end.voxel;
  }
  return best;
}

/// The end nearest to a point, if one is within three radii of it, else the nearest voxel.
int snap(const LumenVoxels& lumen, const Vec3& point, const std::vector<int>& ends) {
  const int voxel = lumen.nearest(point);
  int best = voxel;
  double reach =
      3.0 * double(lumen.depth[std::size_t(voxel)]) + 2.0 * distance(lumen.position(voxel), point);
  for (const int end : ends) {
    const double d = distance(lumen.position(end), point);
    if (d >= reach) continue;
    reach = d;
    best = end;
  }
  return best;
}

double chain_length(const LumenVoxels& lumen, const std::vector<int>& chain) {
  double length = 0.0;
  for (std::size_t i = 1; i < chain.size(); ++i)
    length += distance(lumen.position(chain[i]), lumen.position(chain[i - 1]));
  return length;
}

std::string text(const Vec3& place) {
  const auto mm = [](double value) { return std::to_string(std::lround(value)); };
  return "(" + mm(place.x) + ", " + mm(place.y) + ", " + mm(place.z) + ") mm";
}

std::string sac_warning(const Vec3& tip) {
  return "a sac (aneurysm?) at " + text(tip) + " has no line, because it ends without an outlet";
}

std::string loop_warning(const LumenVoxels& lumen, const std::vector<int>& cuts) {
  std::string places;
  for (const int voxel : cuts) places += (places.empty() ? "" : ", ") + text(lumen.position(voxel));
  return "the vessels form a loop (for example the circle of Willis, or two vessels that touch); "
         "it "
         "was cut at " +
         places + ", and lines end there";
}

void check_tubular(const LumenVoxels& lumen, const std::vector<int>& chain) {
  double deepest = 0.0;
  for (const int v : chain) deepest = std::max(deepest, double(lumen.depth[std::size_t(v)]));
  if (chain_length(lumen, chain) > 3.0 * deepest && lumen.count() >= 20) return;
  throw InputError(
      "the largest piece of the lumen is not a vessel (it is no longer than wide, so no line runs "
      "through it). Check the segmentation, its seeds and its intensity range");
}

}  // namespace

Skeleton find_skeleton(LumenVoxels& lumen, const CenterlineOptions& options) {
  Skeleton skeleton;
  const int deepest =
      int(std::max_element(lumen.depth.begin(), lumen.depth.end()) - lumen.depth.begin());
  const int root = farthest(march(lumen, deepest));
  std::vector<char> near_cut(std::size_t(lumen.count()), 0);
  const std::vector<std::uint32_t> uncut = lumen.links;
  Ends ends = find_ends(lumen, root, options.min_branch_length_mm, near_cut);
  check_tubular(lumen, trace(ends.front, ends.ends.front().voxel));

  std::vector<int> all_ends{root};
  for (const LumenEnd& end : ends.ends) all_ends.push_back(end.voxel);
  const int inlet = options.inlet_lps_mm ? snap(lumen, *options.inlet_lps_mm, all_ends)
                                         : widest_end(lumen, root, ends.front, ends.ends);
  if (inlet != root) {
    lumen.links = uncut;  // a loop is cut where the blood from the inlet meets, not from the root
    near_cut.assign(near_cut.size(), 0);
    ends = find_ends(lumen, inlet, options.min_branch_length_mm, near_cut);
  }
  if (!options.outlets_lps_mm.empty()) {
    std::vector<int> found;
    for (const LumenEnd& end : ends.ends) found.push_back(end.voxel);
    ends.ends.clear();
    for (const Vec3& point : options.outlets_lps_mm)
      ends.ends.push_back({snap(lumen, point, found), 0.0, false});
  }
  skeleton.starts_at_end = std::find(all_ends.begin(), all_ends.end(), inlet) != all_ends.end();
  for (const LumenEnd& end : ends.ends)
    if (end.voxel != inlet)
      skeleton.chains.push_back({trace(ends.front, end.voxel), end.at_loop_cut});
  std::stable_sort(skeleton.chains.begin(), skeleton.chains.end(),
                   [&](const auto& a, const auto& b) {
                     return chain_length(lumen, a.voxels) > chain_length(lumen, b.voxels);
                   });
  for (const LumenEnd& sac : ends.sacs)
    skeleton.warnings.push_back(sac_warning(lumen.position(sac.voxel)));
  if (!ends.loop_cuts.empty()) skeleton.warnings.push_back(loop_warning(lumen, ends.loop_cuts));
  return skeleton;
}

}  // namespace angio::centerline

#include "centerline/detail/skeleton.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "centerline/detail/feeding_chamber.hpp"
#include "centerline/detail/fronts.hpp"
#include "centerline/detail/inlet.hpp"
#include "centerline/detail/places.hpp"
#include "centerline/detail/short_branches.hpp"
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

int farthest(const Front& front) {
  return int(std::max_element(front.length.begin(), front.length.end()) - front.length.begin());
}

struct Ends {
  std::vector<LumenEnd> ends;
  std::vector<LumenEnd> sacs;  ///< stand out like branches, but end without an outlet
  Front front;                 ///< from the source, behind the last cut
  std::vector<int> loop_cuts;  ///< a voxel next to each round's first cut
};

/// Leaves out maxima that are bumps of the wall: a side branch must stand out of its parent by
/// about the parent's diameter, the stump of a vessel by its radius, a tube by 1.5 times its own
/// width.
Ends prune_spurs(const LumenVoxels& lumen, const Front& front, const std::vector<LumenEnd>& maxima,
                 double min_length) {
  Ends result;
  VoxelTree tree(lumen.count());
  const double noise = 4.0 * voxel_size(lumen);
  for (const LumenEnd& end : maxima) {
    std::vector<int> own;
    int v = end.voxel;
    for (; v >= 0 && !tree.has(v); v = front.previous[std::size_t(v)]) own.push_back(v);
    const double parent = v >= 0 ? double(lumen.depth[std::size_t(v)]) : 0.0;
    const auto stands_out = [&] {
      if (min_length > 0.0) return end.prominence >= min_length;
      return end.prominence >= std::max(2.0 * parent, noise) ||
             (end.prominence >= std::max(parent, noise) && is_stump(lumen, tree, own, v)) ||
             is_tube(lumen, own, v, end.prominence);
    };
    const bool is_first = result.ends.empty();
    if (!is_first && !stands_out()) continue;
    const bool sac = !is_first && is_sac(lumen, own, v);
    (sac ? result.sacs : result.ends).push_back(end);
    tree.add(own, v);
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

/// The vessel's radius behind a tip: the greatest depth on the way back, until the way is longer
/// than the vessel is wide.
double radius_behind(const LumenVoxels& lumen, const Front& front, int tip) {
  double deepest = 0.0;
  for (int v = tip; v >= 0; v = front.previous[std::size_t(v)]) {
    deepest = std::max(deepest, double(lumen.depth[std::size_t(v)]));
    if (distance(lumen.position(v), lumen.position(tip)) > 2.0 * deepest + voxel_size(lumen)) break;
  }
  return deepest;
}

/// Adds the ends that are seen from another source only: a wide end beside a long branch hardly
/// stands out when it is looked at from that branch. Tips no farther apart than the vessel is wide
/// are one end.
void add_missing(const LumenVoxels& lumen, const Ends& others, int source, Ends& ends) {
  for (const LumenEnd& other : others.ends) {
    if (std::isinf(ends.front.length[std::size_t(other.voxel)])) continue;
    const Vec3 tip = lumen.position(other.voxel);
    const double reach = 2.0 * radius_behind(lumen, ends.front, other.voxel);
    bool is_known = distance(tip, lumen.position(source)) <= reach;
    for (const auto* some : {&ends.ends, &ends.sacs})
      for (const LumenEnd& end : *some)
        is_known = is_known || distance(tip, lumen.position(end.voxel)) <= reach;
    if (!is_known) ends.ends.push_back(other);
  }
}

/// Whether the border of the volume cuts a vessel off, rather than a wall ending it.
bool is_cut_off(const LumenVoxels& lumen, const std::vector<int>& tip_first) {
  std::vector<Vec3> points;
  std::vector<double> depth;
  for (const int v : tip_first) {
    points.push_back(lumen.position(v));
    depth.push_back(double(lumen.depth[std::size_t(v)]));
  }
  const auto cap = std::ptrdiff_t(end_of_cap(points, depth));
  return std::any_of(tip_first.begin(), tip_first.begin() + cap + 1,
                     [&](int v) { return at_border(lumen, v); });
}

struct Rim {
  int voxel = -1;  ///< in its middle
  OpenRim opening;
};

/// @param front  from the root
/// @param rims   where there are two or more, blood comes in by one of them
int find_inlet(const LumenVoxels& lumen, int root, const Front& front,
               const std::vector<LumenEnd>& ends, const std::vector<Rim>& rims,
               std::vector<std::string>& warnings) {
  std::vector<InletCandidate> candidates;
  const auto add = [&](int voxel, const std::vector<int>& tip_first, bool at_loop_cut) {
    InletCandidate candidate{voxel, is_cut_off(lumen, tip_first)};
    const auto rim = std::find_if(rims.begin(), rims.end(),
                                  [&](const Rim& some) { return some.voxel == voxel; });
    candidate.is_open = rims.size() < 2 || (rim != rims.end() && !at_loop_cut);
    if (rim != rims.end()) candidate.opening = rim->opening.radius;
    candidates.push_back(candidate);
  };
  add(root, trace(front, ends.front().voxel), false);
  for (const LumenEnd& end : ends) {
    if (end.voxel == root) continue;
    std::vector<int> chain = trace(front, end.voxel);
    std::reverse(chain.begin(), chain.end());
    add(end.voxel, chain, end.at_loop_cut);
  }
  if (rims.size() < 2) {
    std::vector<std::vector<int>> paths;
    for (const LumenEnd& end : ends) paths.push_back(trace(front, end.voxel));
    if (const auto chamber = find_feeding_chamber(lumen, paths)) {
      warnings.push_back("the tree is fed by the wide chamber at " +
                         in_words(lumen.position(*chamber)) +
                         " (an aortic root?); its lines begin there");
      return *chamber;
    }
  }
  const InletChoice choice = choose_inlet(lumen, front, candidates);
  const auto place = [&](std::size_t c) { return in_words(lumen.position(candidates[c].voxel)); };
  if (choice.rival)
    warnings.push_back("the inlet is not certain: the end at " + place(choice.best) +
                       " was taken, the one at " + place(*choice.rival) +
                       " is nearly as likely. --inlet says which it is");
  return candidates[choice.best].voxel;
}

/// Makes every open rim an end, and no end of what else stands out but long vessels.
/// @param rims  voxels in the middle of the rims
/// @param closed  gets the tips of vessels that end without a rim
void take_rims(const LumenVoxels& lumen, const std::vector<int>& rims, int source, Ends& ends,
               std::vector<int>& closed) {
  constexpr double kLong = 6.0;  // radii
  std::vector<LumenEnd> kept;
  for (const int rim : rims) {
    if (rim == source || std::isinf(ends.front.length[std::size_t(rim)])) continue;
    kept.push_back({rim, ends.front.length[std::size_t(rim)], false});
  }
  std::vector<char> in_tree(std::size_t(lumen.count()), 0);
  for (const LumenEnd& end : kept)
    for (int v = end.voxel; v >= 0; v = ends.front.previous[std::size_t(v)])
      in_tree[std::size_t(v)] = 1;
  for (const LumenEnd& end : ends.ends) {
    double length = 0.0, radius = 0.0;
    int v = end.voxel;
    for (; v >= 0 && in_tree[std::size_t(v)] == 0; v = ends.front.previous[std::size_t(v)]) {
      radius = std::max(radius, double(lumen.depth[std::size_t(v)]));
      const int next = ends.front.previous[std::size_t(v)];
      if (next >= 0) length += distance(lumen.position(v), lumen.position(next));
    }
    // From its parent's wall on; a tip next to a rim is the edge of that rim's cap.
    if (v >= 0) length -= double(lumen.depth[std::size_t(v)]);
    if (length < kLong * std::max(radius, voxel_size(lumen))) continue;
    kept.push_back(end);
    closed.push_back(end.voxel);
    for (int w = end.voxel; w >= 0 && in_tree[std::size_t(w)] == 0;
         w = ends.front.previous[std::size_t(w)])
      in_tree[std::size_t(w)] = 1;
  }
  ends.ends = std::move(kept);
}

/// The open rims of the piece that is followed.
std::vector<Rim> find_rims(const LumenVoxels& lumen, const std::vector<OpenRim>& open_rims,
                           std::vector<std::string>& warnings) {
  std::vector<Rim> rims;
  for (const OpenRim& open_rim : open_rims) {
    const Vec3& middle = open_rim.middle;
    const int voxel = lumen.nearest(middle);
    const double away = distance(lumen.position(voxel), middle);
    const bool is_known =
        std::any_of(rims.begin(), rims.end(), [&](const Rim& rim) { return rim.voxel == voxel; });
    if (away > 3.0 * voxel_size(lumen) + double(lumen.depth[std::size_t(voxel)]))
      warnings.push_back("the open rim at " + in_words(middle) +
                         " has no line (its vessel is not connected to the others, or thinner "
                         "than can be followed)");
    else if (!is_known)
      rims.push_back({voxel, open_rim});
  }
  return rims;
}

/// The middle of the rim that a voxel stands for, if it does.
std::optional<Vec3> middle_of_rim(const std::vector<Rim>& rims, int voxel) {
  for (const Rim& rim : rims)
    if (rim.voxel == voxel) return rim.opening.middle;
  return std::nullopt;
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

std::vector<Vec3> positions(const LumenVoxels& lumen, const std::vector<int>& voxels) {
  std::vector<Vec3> places;
  for (const int voxel : voxels) places.push_back(lumen.position(voxel));
  return places;
}

/// What stands out without an outlet, ends closed, or was cut; a note a kind.
std::vector<std::string> notes_on(const LumenVoxels& lumen, const Ends& ends,
                                  const std::vector<int>& closed) {
  std::vector<std::string> notes;
  std::vector<int> sacs;
  for (const LumenEnd& sac : ends.sacs) sacs.push_back(sac.voxel);
  if (!sacs.empty())
    notes.push_back("a sac (aneurysm?) " + at_places(positions(lumen, sacs)) +
                    " has no line, because it ends without an outlet");
  if (!closed.empty())
    notes.push_back("a vessel ends closed " + at_places(positions(lumen, closed)) +
                    "; its tip counts as an outlet");
  if (!ends.loop_cuts.empty())
    notes.push_back(
        "the vessels form a loop (for example the circle of Willis, or two vessels that touch); "
        "it was cut " +
        at_places(positions(lumen, ends.loop_cuts)) + ", and lines end there");
  return notes;
}

void check_tubular(const LumenVoxels& lumen, const Ends& ends) {
  const std::vector<int> chain =
      ends.ends.empty() ? std::vector<int>{} : trace(ends.front, ends.ends.front().voxel);
  double deepest = 0.0;
  for (const int v : chain) deepest = std::max(deepest, double(lumen.depth[std::size_t(v)]));
  if (chain_length(lumen, chain) > 3.0 * deepest && lumen.count() >= 20) return;
  throw InputError(
      "the largest piece of the lumen is not a vessel (it is no longer than wide, so no line runs "
      "through it). Check the segmentation, its seeds and its intensity range");
}

}  // namespace

Skeleton find_skeleton(LumenVoxels& lumen, const CenterlineOptions& options,
                       const std::vector<OpenRim>& open_rims) {
  Skeleton skeleton;
  const std::vector<Rim> open_ends = find_rims(lumen, open_rims, skeleton.warnings);
  std::vector<int> rims;
  for (const Rim& rim : open_ends) rims.push_back(rim.voxel);
  const bool has_rims = rims.size() >= 2;
  const int deepest =
      int(std::max_element(lumen.depth.begin(), lumen.depth.end()) - lumen.depth.begin());
  const int root = has_rims ? rims.front() : farthest(march(lumen, deepest));
  std::vector<char> near_cut(std::size_t(lumen.count()), 0);
  const std::vector<std::uint32_t> uncut = lumen.links;
  std::vector<int> closed;
  const auto find_from = [&](int source) {
    lumen.links = uncut;  // a loop is cut where the blood from the inlet meets, not from the root
    near_cut.assign(near_cut.size(), 0);
    closed.clear();
    Ends ends = find_ends(lumen, source, options.min_branch_length_mm, near_cut);
    if (has_rims) take_rims(lumen, rims, source, ends, closed);
    return ends;
  };
  int source = root;
  Ends ends = find_from(root);
  if (!has_rims) {
    check_tubular(lumen, ends);
    source = ends.ends.front().voxel;
    const Ends from_root = std::exchange(ends, find_from(source));
    add_missing(lumen, from_root, source, ends);
  }

  std::vector<int> all_ends{source};
  for (const LumenEnd& end : ends.ends) all_ends.push_back(end.voxel);
  const int inlet = options.inlet_lps_mm ? snap(lumen, *options.inlet_lps_mm, all_ends)
                                         : find_inlet(lumen, source, ends.front, ends.ends,
                                                      open_ends, skeleton.warnings);
  if (inlet != source) ends = find_from(inlet);
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
      skeleton.chains.push_back(
          {trace(ends.front, end.voxel), end.at_loop_cut, middle_of_rim(open_ends, end.voxel)});
  skeleton.inlet_rim = middle_of_rim(open_ends, inlet);
  std::stable_sort(skeleton.chains.begin(), skeleton.chains.end(),
                   [&](const auto& a, const auto& b) {
                     return chain_length(lumen, a.voxels) > chain_length(lumen, b.voxels);
                   });
  for (std::string& note : notes_on(lumen, ends, closed))
    skeleton.warnings.push_back(std::move(note));
  return skeleton;
}

}  // namespace angio::centerline

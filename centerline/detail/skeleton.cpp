#include "centerline/detail/skeleton.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "centerline/detail/ends.hpp"
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

int farthest(const Front& front) {
  return int(std::max_element(front.length.begin(), front.length.end()) - front.length.begin());
}

/// Points of a closed end in its cap: up to the last ball that the vessel's sides hold.
int cap_length(const LumenVoxels& lumen, const std::vector<int>& tip_first) {
  std::vector<Vec3> points;
  std::vector<double> depth;
  for (const int v : tip_first) {
    points.push_back(lumen.position(v));
    depth.push_back(double(lumen.depth[std::size_t(v)]));
  }
  return end_of_cap(points, depth);
}

/// Where a person who looks for an end finds its lumen: a tip lies in its rim.
Vec3 middle_of_end(const LumenVoxels& lumen, const std::vector<int>& tip_first) {
  return lumen.position(tip_first[std::size_t(cap_length(lumen, tip_first))]);
}

/// Whether the border of the volume cuts a vessel off, rather than a wall ending it.
bool is_cut_off(const LumenVoxels& lumen, const std::vector<int>& tip_first) {
  const int cap = cap_length(lumen, tip_first);
  return std::any_of(tip_first.begin(), tip_first.begin() + cap + 1,
                     [&](int v) { return at_border(lumen, v); });
}

/// @param front  from the root
/// @param rims   where there are two or more, blood comes in by one of them, or by a far wider tip
int find_inlet(const LumenVoxels& lumen, int root, const Front& front,
               const std::vector<LumenEnd>& ends, const std::vector<Rim>& rims, bool are_caps,
               std::vector<std::string>& warnings) {
  std::vector<InletCandidate> candidates;
  std::vector<Vec3> middles;  // of the candidates' ends
  const auto add = [&](int voxel, const std::vector<int>& tip_first, bool at_loop_cut,
                       const std::optional<double>& tube_radius) {
    InletCandidate candidate{voxel, is_cut_off(lumen, tip_first)};
    if (tube_radius) candidate.opening = *tube_radius;
    const auto rim = std::find_if(rims.begin(), rims.end(),
                                  [&](const Rim& some) { return some.voxel == voxel; });
    candidate.is_open = !at_loop_cut;
    candidate.is_tip = rims.size() >= 2 && rim == rims.end();
    if (rim != rims.end()) {
      candidate.opening = rim->opening.radius;
      candidate.is_cut_off = candidate.is_cut_off || are_caps;
    }
    candidates.push_back(candidate);
    middles.push_back(rim != rims.end() ? rim->opening.middle : middle_of_end(lumen, tip_first));
  };
  add(root, trace(front, ends.front().voxel), false, {});
  for (const LumenEnd& end : ends) {
    if (end.voxel == root) continue;
    std::vector<int> chain = trace(front, end.voxel);
    std::reverse(chain.begin(), chain.end());
    add(end.voxel, chain, end.at_loop_cut || end.is_meeting, end.tube_radius);
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
  const auto place = [&](std::size_t c) { return in_words(middles[c]); };
  if (choice.rival)
    warnings.push_back(std::string(candidates.size() > 2 ? kUncertainInlet : kEitherEnd) +
                       ": the end at " + place(choice.best) + " was taken, the one at " +
                       place(*choice.rival) + " is nearly as likely. --inlet says which it is");
  return candidates[choice.best].voxel;
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
    if (away > 3.0 * lumen.geometry.longest_spacing() + double(lumen.depth[std::size_t(voxel)]))
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
  // Next to a cut the line of the other side ends, and no vessel.
  std::vector<int> tips = closed;
  std::erase_if(tips, [&](int tip) {
    constexpr double kNear = 2.0;  // depths
    return std::any_of(ends.loop_cuts.begin(), ends.loop_cuts.end(), [&](int cut) {
      return distance(lumen.position(tip), lumen.position(cut)) <
             kNear *
                 std::max(double(lumen.depth[std::size_t(cut)]), lumen.geometry.longest_spacing());
    });
  });
  std::vector<Vec3> middles;
  for (const int tip : tips) {
    std::vector<int> chain = trace(ends.front, tip);
    std::reverse(chain.begin(), chain.end());
    middles.push_back(middle_of_end(lumen, chain));
  }
  if (!tips.empty())
    notes.push_back("a vessel ends closed " + at_places(middles) + "; its tip counts as an outlet");
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

/// The most prominent end, if there is one, that is not where the ways round a loop meet.
int most_prominent(const std::vector<LumenEnd>& ends) {
  const auto at_wall = std::find_if(ends.begin(), ends.end(), [](const LumenEnd& end) {
    return !end.at_loop_cut && !end.is_meeting;
  });
  return (at_wall != ends.end() ? *at_wall : ends.front()).voxel;
}

/// The middle of the rim, flat end or stump where the lines begin, if they do at one.
std::optional<Vec3> middle_of_inlet(const LumenVoxels& lumen, const std::vector<Rim>& rims,
                                    const std::vector<OpenRim>& flat_ends,
                                    const std::vector<LumenEnd>& ends, int inlet) {
  if (const auto rim = middle_of_rim(rims, inlet)) return rim;
  if (const auto flat = flat_end_at(lumen, flat_ends, inlet)) return flat;
  for (const LumenEnd& end : ends)
    if (end.voxel == inlet) return end.middle;
  return std::nullopt;
}

/// The ways from the inlet to the ends, the longest first.
std::vector<Skeleton::Chain> chains_to(const LumenVoxels& lumen, const Ends& ends,
                                       const std::vector<Rim>& rims, int inlet) {
  std::vector<Skeleton::Chain> chains;
  for (const LumenEnd& end : ends.ends) {
    if (end.voxel == inlet) continue;
    const std::optional<Vec3> rim = middle_of_rim(rims, end.voxel);
    chains.push_back({trace(ends.front, end.voxel), end.at_loop_cut, rim ? rim : end.middle});
  }
  std::stable_sort(chains.begin(), chains.end(), [&](const auto& a, const auto& b) {
    return chain_length(lumen, a.voxels) > chain_length(lumen, b.voxels);
  });
  return chains;
}

/// What was found from the root, and what that has changed.
struct SeenFromRoot {
  Ends ends;
  std::vector<std::uint32_t> links;
  std::vector<char> near_cut;
};

}  // namespace

Skeleton find_skeleton(LumenVoxels& lumen, const CenterlineOptions& options,
                       const Openings& openings, const Progress& progress) {
  Skeleton skeleton;
  const std::vector<Rim> open_ends = find_rims(lumen, openings.rims, skeleton.warnings);
  const bool has_rims = open_ends.size() >= 2;
  const int deepest =
      int(std::max_element(lumen.depth.begin(), lumen.depth.end()) - lumen.depth.begin());
  const int root = has_rims ? open_ends.front().voxel : farthest(march(lumen, deepest));
  std::vector<char> near_cut(std::size_t(lumen.count()), 0);
  const std::vector<std::uint32_t> uncut = lumen.links;
  std::vector<int> closed;
  int passes = 0;
  const auto find_from = [&](int source) {
    constexpr double kMostPasses = 3.0;  // from the root, the farthest end, the inlet
    const Progress pass = part(progress, passes / kMostPasses, (passes + 1) / kMostPasses);
    ++passes;
    lumen.links = uncut;  // a loop is cut where the blood from the inlet meets, not from the root
    near_cut.assign(near_cut.size(), 0);
    closed.clear();
    Ends ends =
        find_ends(lumen, source, openings.flat_ends, options.min_branch_length_mm, near_cut, pass);
    if (has_rims)
      take_rims(lumen, open_ends, openings.are_caps, source, ends, closed);
    else
      add_border_sections(lumen, source, ends);
    return ends;
  };
  int source = root;
  SeenFromRoot seen;
  Ends ends = find_from(root);
  if (!has_rims) {
    check_tubular(lumen, ends);
    source = most_prominent(ends.ends);
    seen = {std::move(ends), lumen.links, near_cut};
    ends = find_from(source);
    add_missing(lumen, seen.ends, source, ends);
  }

  std::vector<int> all_ends{source};
  for (const LumenEnd& end : ends.ends) all_ends.push_back(end.voxel);
  const int inlet = options.inlet_lps_mm
                        ? snap(lumen, *options.inlet_lps_mm, all_ends)
                        : find_inlet(lumen, source, ends.front, ends.ends, open_ends,
                                     openings.are_caps, skeleton.warnings);
  skeleton.inlet_rim = middle_of_inlet(lumen, open_ends, openings.flat_ends, ends.ends, inlet);
  if (inlet == root && !has_rims && inlet != source) {
    ends = std::move(seen.ends);  // as find_from(root) would find it again
    lumen.links = std::move(seen.links);
    near_cut = std::move(seen.near_cut);
  } else if (inlet != source) {
    ends = find_from(inlet);
  }
  if (!options.outlets_lps_mm.empty()) {
    std::vector<int> found;
    for (const LumenEnd& end : ends.ends) found.push_back(end.voxel);
    ends.ends.clear();
    for (const Vec3& point : options.outlets_lps_mm)
      ends.ends.push_back({snap(lumen, point, found), 0.0});
  }
  skeleton.starts_at_end = std::find(all_ends.begin(), all_ends.end(), inlet) != all_ends.end();
  skeleton.chains = chains_to(lumen, ends, open_ends, inlet);
  for (std::string& note : notes_on(lumen, ends, closed))
    skeleton.warnings.push_back(std::move(note));
  return skeleton;
}

}  // namespace angio::centerline

#include "centerline/detail/ends.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "centerline/detail/short_branches.hpp"

namespace angio::centerline {

namespace {

bool is_on(const LumenVoxels& lumen, const OpenRim& flat_end, int tip) {
  constexpr double kOnCap = 1.25;
  return distance(lumen.position(tip), flat_end.middle) < kOnCap * flat_end.radius;
}

/// The flat ends of a surface, each of which is one end.
class FlatEnds {
 public:
  FlatEnds(const std::vector<OpenRim>& ends, const LumenVoxels& lumen)
      : ends_(ends), is_taken_(ends.size(), 0), lumen_(lumen) {}
  [[nodiscard]] std::size_t count() const { return ends_.size(); }
  /// The middle of the one that a tip lies on, if none did before.
  std::optional<Vec3> take(int tip) {
    for (std::size_t f = 0; f < ends_.size(); ++f)
      if (is_on(lumen_, ends_[f], tip) && std::exchange(is_taken_[f], char(1)) == 0)
        return ends_[f].middle;
    return std::nullopt;
  }

 private:
  const std::vector<OpenRim>& ends_;
  std::vector<char> is_taken_;
  const LumenVoxels& lumen_;
};

/// Marks the ends that lie at a cut through a loop.
/// @param near_cut  1 for the voxels next to a cut, shape [voxel]
void mark_loop_cuts(const LumenVoxels& lumen, const Front& front, const std::vector<char>& near_cut,
                    std::vector<LumenEnd>& ends) {
  const double reach = 2.0 * lumen.geometry.longest_spacing();
  for (LumenEnd& end : ends)
    for (int v = end.voxel;
         v >= 0 && distance(lumen.position(v), lumen.position(end.voxel)) <= reach;
         v = front.previous[std::size_t(v)])
      end.at_loop_cut = end.at_loop_cut || near_cut[std::size_t(v)] != 0;
}

/// Leaves out maxima that are bumps of the wall: a side branch must stand out of its parent by
/// about the parent's diameter, the stump of a vessel by three quarters of its radius (the corner
/// of a sharp bend does by less than half), a tube by 1.5 times its own width, unless it is what is
/// left of a bridge that was cut.
Ends prune_spurs(const LumenVoxels& lumen, const Front& front, const std::vector<LumenEnd>& maxima,
                 FlatEnds flat_ends, double min_length) {
  constexpr double kStump = 0.75;
  constexpr std::size_t kOthers = 2;  // flat ends: then vessels are cut off, and a sac is round
  Ends result;
  VoxelTree tree(lumen.count());
  const double noise = 4.0 * lumen.geometry.longest_spacing();
  for (LumenEnd end : maxima) {
    std::vector<int> own;
    int v = end.voxel;
    for (; v >= 0 && !tree.has(v); v = front.previous[std::size_t(v)]) own.push_back(v);
    const double parent = v >= 0 ? double(lumen.depth[std::size_t(v)]) : 0.0;
    const auto stands_out = [&] {
      if (min_length > 0.0) return end.prominence >= min_length;
      if (end.prominence >= std::max(2.0 * parent, noise)) return true;
      if (end.prominence >= std::max(kStump * parent, noise))
        end.middle = end_of_stump(lumen, tree, own, v);
      if (!end.middle && !end.at_loop_cut)
        end.tube_radius = radius_of_tube(lumen, own, v, end.prominence);
      return end.middle || end.tube_radius;
    };
    const bool is_first = result.ends.empty();
    end.middle = flat_ends.take(end.voxel);
    const bool is_flat = end.middle.has_value();
    if (!is_first && !is_flat && !stands_out()) continue;
    const bool sac = !is_first && !is_flat && is_sac(lumen, own, v, flat_ends.count() >= kOthers);
    (sac ? result.sacs : result.ends).push_back(end);
    tree.add(own, v);
  }
  return result;
}

}  // namespace

Ends find_ends(LumenVoxels& lumen, int source, const std::vector<OpenRim>& flat_ends,
               double min_length, std::vector<char>& near_cut, const Progress& progress) {
  Ends result;
  constexpr int kMostRounds = 6;  // a cut can lay open another loop; more than this is a sponge
  result.front = march(lumen, source);
  const Front& front = result.front;
  for (int round = 0;; ++round) {
    progress.report((round + 1.0) / (kMostRounds + 2.0), "finding the ends");
    auto maxima = find_maxima(lumen, front, 2.0 * lumen.geometry.longest_spacing());
    mark_loop_cuts(lumen, front, near_cut, maxima);
    FlatEnds flat(flat_ends, lumen);
    flat.take(source);
    Ends found = prune_spurs(lumen, front, maxima, std::move(flat), min_length);
    result.ends = std::move(found.ends);
    result.sacs = std::move(found.sacs);
    std::vector<int> cut, meetings;
    for (LumenEnd& end : result.ends) {
      const std::optional<int> met = meeting_front(lumen, front, end.voxel);
      if (!met) continue;
      end.is_meeting = true;
      meetings.push_back(end.voxel);
      if (round < kMostRounds && cut.empty())
        cut = cut_bridge_behind(lumen, front, end.voxel, *met);
    }
    const auto with_meetings = [&] {
      result.loop_cuts.insert(result.loop_cuts.end(), meetings.begin(), meetings.end());
      return std::move(result);
    };
    if (round == kMostRounds) return with_meetings();
    std::vector<std::vector<int>> paths;
    for (const auto* some : {&result.ends, &result.sacs})
      for (const LumenEnd& end : *some) paths.push_back(trace(front, end.voxel));
    if (cut.empty()) cut = cut_loops(lumen, front, paths);
    if (cut.empty()) return with_meetings();
    result.loop_cuts.push_back(cut.front());
    for (const int v : cut) near_cut[std::size_t(v)] = 1;
    march_round_cuts(lumen, result.front);
  }
}

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

namespace {

/// Where the border of the volume cuts the lumen.
struct BorderSection {
  int deepest = -1;   ///< the voxel in its middle
  double area = 0.0;  ///< [mm^2]
};

/// The area in which a voxel lies open at the border [mm^2]; 0: it does not.
double open_area(const LumenVoxels& lumen, int voxel) {
  const auto at = lumen.index(voxel);
  const Vec3& h = lumen.geometry.spacing;
  double area = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    const int i = at[a] + lumen.corner[a];
    const bool is_open = i == 0 || i == lumen.geometry.size[a] - 1;
    if (is_open) area += h.x * h.y * h.z / h[int(a)];
  }
  return area;
}

std::vector<BorderSection> find_border_sections(const LumenVoxels& lumen) {
  std::vector<BorderSection> sections;
  std::vector<char> is_seen(std::size_t(lumen.count()), 0);
  std::vector<int> stack;
  for (int seed = 0; seed < lumen.count(); ++seed) {
    if (is_seen[std::size_t(seed)] != 0 || open_area(lumen, seed) == 0.0) continue;
    BorderSection& section = sections.emplace_back();
    section.deepest = seed;
    is_seen[std::size_t(seed)] = 1;
    stack.assign(1, seed);
    while (!stack.empty()) {
      const int v = stack.back();
      stack.pop_back();
      section.area += open_area(lumen, v);
      if (lumen.depth[std::size_t(v)] > lumen.depth[std::size_t(section.deepest)])
        section.deepest = v;
      for (int n = 0; n < kNeighborCount; ++n) {
        const int w = lumen.neighbor(v, n);
        if (w < 0 || is_seen[std::size_t(w)] != 0 || open_area(lumen, w) == 0.0) continue;
        is_seen[std::size_t(w)] = 1;
        stack.push_back(w);
      }
    }
  }
  return sections;
}

}  // namespace

void add_border_sections(const LumenVoxels& lumen, int source, Ends& ends) {
  constexpr double kRound = 1.5, kNear = 3.0, kLeastVoxels = 2.0;  // radii; voxels
  for (const BorderSection& section : find_border_sections(lumen)) {
    const auto v = std::size_t(section.deepest);
    const double radius = double(lumen.depth[v]);
    if (radius < kLeastVoxels * lumen.geometry.longest_spacing() ||
        std::isinf(ends.front.length[v]))
      continue;
    if (std::sqrt(section.area / std::numbers::pi) > kRound * radius) continue;
    const auto is_near = [&](int tip) {
      return distance(lumen.position(tip), lumen.position(section.deepest)) < kNear * radius;
    };
    const auto is_near_end = [&](const LumenEnd& end) { return is_near(end.voxel); };
    if (is_near(source) || std::any_of(ends.ends.begin(), ends.ends.end(), is_near_end)) continue;
    ends.ends.push_back({section.deepest, ends.front.length[v]});
  }
}

void take_rims(const LumenVoxels& lumen, const std::vector<Rim>& rims, bool are_caps, int source,
               Ends& ends, std::vector<int>& closed) {
  constexpr double kLong = 6.0, kLongerThanWide = 2.0, kStump = 0.5;  // radii
  const Front& front = ends.front;
  std::vector<LumenEnd> kept;
  for (const Rim& rim : rims) {
    if (rim.voxel == source || std::isinf(front.length[std::size_t(rim.voxel)])) continue;
    kept.push_back({rim.voxel, front.length[std::size_t(rim.voxel)]});
  }
  std::vector<char> in_tree(std::size_t(lumen.count()), 0);
  const auto add_to_tree = [&](int tip) {
    for (int v = tip; v >= 0 && in_tree[std::size_t(v)] == 0; v = front.previous[std::size_t(v)])
      in_tree[std::size_t(v)] = 1;
  };
  for (const LumenEnd& end : kept) add_to_tree(end.voxel);
  /// A tip's way to the tree from its parent's wall, in radii; a tip next to a rim is the edge of
  /// that rim's cap, and has none.
  const auto length_of = [&](int tip) {
    double length = 0.0, radius = lumen.geometry.longest_spacing();
    int v = tip;
    for (; v >= 0 && in_tree[std::size_t(v)] == 0; v = front.previous[std::size_t(v)]) {
      radius = std::max(radius, double(lumen.depth[std::size_t(v)]));
      const int next = front.previous[std::size_t(v)];
      if (next >= 0) length += distance(lumen.position(v), lumen.position(next));
    }
    return (length - (v >= 0 ? double(lumen.depth[std::size_t(v)]) : 0.0)) / radius;
  };
  const auto tips = std::count_if(ends.ends.begin(), ends.ends.end(), [&](const LumenEnd& end) {
    return length_of(end.voxel) >= kLongerThanWide;
  });
  // Bumps of a ragged wall stand out, too: open rims tell where the vessels end unless they are
  // few.
  const std::ptrdiff_t most = (are_caps ? 1 : 2) * std::ptrdiff_t(rims.size());
  const double least = tips > most ? kLongerThanWide : kLong;
  const auto is_on_a_rim = [&](int tip) {
    return std::any_of(rims.begin(), rims.end(),
                       [&](const Rim& rim) { return is_on(lumen, rim.opening, tip); });
  };
  for (const LumenEnd& end : ends.ends) {
    if (is_on_a_rim(end.voxel)) continue;
    const bool is_flat_or_stump = are_caps && end.middle;
    if (length_of(end.voxel) < (is_flat_or_stump ? kStump : least)) continue;
    kept.push_back(end);
    if (!end.at_loop_cut && !end.is_meeting) closed.push_back(end.voxel);
    add_to_tree(end.voxel);
  }
  ends.ends = std::move(kept);
}

std::optional<Vec3> flat_end_at(const LumenVoxels& lumen, const std::vector<OpenRim>& flat_ends,
                                int tip) {
  for (const OpenRim& flat_end : flat_ends)
    if (is_on(lumen, flat_end, tip)) return flat_end.middle;
  return std::nullopt;
}

}  // namespace angio::centerline

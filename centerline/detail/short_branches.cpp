#include "centerline/detail/short_branches.hpp"

#include <algorithm>
#include <cmath>

#include "core/statistics.hpp"

namespace angio::centerline {

void VoxelTree::add(const std::vector<int>& own, int junction) {
  for (std::size_t i = own.size(); i-- > 0;) {
    const int before = i + 1 < own.size() ? own[i + 1] : junction;
    const auto voxel = std::size_t(own[i]);
    toward_root_[voxel] = before < 0 ? kNone : before;
    if (before < 0) continue;
    int* last = &first_away_[std::size_t(before)];
    while (*last >= 0) last = &next_beside_[std::size_t(*last)];
    *last = own[i];
  }
}

std::vector<std::vector<int>> VoxelTree::arms(const LumenVoxels& lumen, int voxel,
                                              double length) const {
  const Vec3 from = lumen.position(voxel);
  const auto walk = [&](int first, const std::vector<int>& next) {
    std::vector<int> arm;
    for (int v = first; v >= 0; v = next[std::size_t(v)]) {
      arm.push_back(v);
      if (distance(lumen.position(v), from) > length) break;
    }
    return arm;
  };
  std::vector<std::vector<int>> arms;
  if (toward_root_[std::size_t(voxel)] >= 0)
    arms.push_back(walk(toward_root_[std::size_t(voxel)], toward_root_));
  for (int v = first_away_[std::size_t(voxel)]; v >= 0; v = next_beside_[std::size_t(v)])
    arms.push_back(walk(v, first_away_));
  return arms;
}

bool at_border(const LumenVoxels& lumen, int voxel) {
  const auto at = lumen.index(voxel);
  for (std::size_t a = 0; a < 3; ++a)
    if (at[a] + lumen.corner[a] == 0 || at[a] + lumen.corner[a] == lumen.geometry.size[a] - 1)
      return true;
  return false;
}

bool is_sac(const LumenVoxels& lumen, const std::vector<int>& own, int junction,
            bool others_are_cut) {
  constexpr double kWider = 1.2, kLonger = 1.5, kWiderThanParent = 1.3, kLongerAndWide = 2.5;
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
  const double parent = double(lumen.depth[std::size_t(junction)]);
  const auto is_shorter_than = [&](double widths) { return length < widths * 2.0 * widest; };
  if (others_are_cut && widest > kWider * parent && is_shorter_than(kLongerAndWide)) return true;
  const bool is_wide = widest > kWiderThanParent * parent;
  return widest > kWider * mouth && is_shorter_than(is_wide ? kLongerAndWide : kLonger);
}

namespace {

/// What an arm of a fork looks like from it, outside the ball that fits there.
struct Arm {
  double radius = 0.0;  ///< [mm]; 0: it does not leave the ball
  Vec3 direction;       ///< unit, away from the fork
};

/// @param voxels  away from the fork
/// @param radius_of  of the depths outside the fork's ball
template <class RadiusOf>
Arm see_arm(const LumenVoxels& lumen, int fork, const std::vector<int>& voxels,
            RadiusOf radius_of) {
  const Vec3 from = lumen.position(fork);
  std::vector<float> depths;
  Vec3 middle;
  for (const int v : voxels) {
    const Vec3 away = lumen.position(v) - from;
    if (norm(away) < double(lumen.depth[std::size_t(fork)])) continue;
    depths.push_back(lumen.depth[std::size_t(v)]);
    middle += away;
  }
  if (depths.empty()) return {};
  return {double(radius_of(std::move(depths))), normalized(middle)};
}

}  // namespace

std::optional<Vec3> end_of_stump(const LumenVoxels& lumen, const VoxelTree& tree,
                                 const std::vector<int>& own, int junction) {
  constexpr double kInLine = -0.42, kWider = 4.0 / 3.0, kThin = 0.6, kReach = 3.0;
  if (own.empty() || junction < 0) return std::nullopt;
  const std::vector<int> away(own.rbegin(), own.rend());
  const Arm stump = see_arm(lumen, junction, away, [](const std::vector<float>& depths) {
    return *std::max_element(depths.begin(), depths.end());  // towards its cap it narrows
  });
  const double reach = kReach * double(lumen.depth[std::size_t(junction)]);
  std::vector<Arm> arms;
  for (const std::vector<int>& voxels : tree.arms(lumen, junction, reach))
    arms.push_back(see_arm(lumen, junction, voxels,
                           [](std::vector<float> depths) { return median(std::move(depths)); }));
  const auto widest = std::max_element(
      arms.begin(), arms.end(), [](const Arm& a, const Arm& b) { return a.radius < b.radius; });
  if (arms.size() < 2) return std::nullopt;
  const auto is_thin = [&](const Arm& arm) {
    return &arm == &*widest || arm.radius < kThin * widest->radius;
  };
  const bool is_stump = stump.radius * kWider > widest->radius &&
                        stump.radius < kWider * widest->radius &&
                        dot(stump.direction, widest->direction) < kInLine &&
                        std::all_of(arms.begin(), arms.end(), is_thin);
  if (!is_stump) return std::nullopt;
  // Past the middle of its widest ball, as far as that reaches: a path ends in a cap's edge.
  const Vec3 from = lumen.position(junction);
  int widest_ball = own.back();
  for (const int v : own)
    if (distance(lumen.position(v), from) >= double(lumen.depth[std::size_t(junction)]) &&
        lumen.depth[std::size_t(v)] >= lumen.depth[std::size_t(widest_ball)])
      widest_ball = v;
  const Vec3 center = lumen.position(widest_ball);
  return center + double(lumen.depth[std::size_t(widest_ball)]) * normalized(center - from);
}

std::optional<double> radius_of_tube(const LumenVoxels& lumen, const std::vector<int>& own,
                                     int junction, double prominence) {
  constexpr double kLonger = 1.5, kLeastVoxels = 2.0, kThinner = 0.75;
  if (own.empty() || junction < 0) return std::nullopt;
  const Vec3 tip = lumen.position(own.front()), parent = lumen.position(junction);
  double widest = kLeastVoxels * lumen.geometry.longest_spacing();
  for (const int v : own) {
    const Vec3 here = lumen.position(v);
    if (distance(here, parent) <= double(lumen.depth[std::size_t(junction)])) break;
    widest = std::max(widest, double(lumen.depth[std::size_t(v)]));
    if (widest > kThinner * double(lumen.depth[std::size_t(junction)])) break;
    if (std::min(distance(here, tip), prominence) >= kLonger * 2.0 * widest) return widest;
  }
  return std::nullopt;
}

}  // namespace angio::centerline

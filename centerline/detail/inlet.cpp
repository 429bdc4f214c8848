#include "centerline/detail/inlet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "core/statistics.hpp"

namespace angio::centerline {
namespace {

/// A stretch of the tree between two forks, or a fork and an end; the first one leaves the root.
struct BranchStretch {
  int parent = -1;
  std::vector<int> children;
  std::vector<int> voxels;  ///< away from the root
  double radius = 0.0;      ///< median depth [mm]
  bool is_stub = false;     ///< it lies in the forks and caps at its ends
  Vec3 at_begin, at_end;    ///< unit, into the stretch, away from the fork at that end
};

double deepest_in(const LumenVoxels& lumen, const BranchStretch& stretch) {
  double deepest = 0.0;
  for (const int v : stretch.voxels)
    deepest = std::max(deepest, double(lumen.depth[std::size_t(v)]));
  return deepest;
}

/// A stretch without the forks at its ends: what is farther than their depth from them.
std::vector<int> own_voxels(const LumenVoxels& lumen, const BranchStretch& stretch) {
  std::vector<int> own;
  const Vec3 begin = lumen.position(stretch.voxels.front());
  const Vec3 end = lumen.position(stretch.voxels.back());
  const double begin_reach = double(lumen.depth[std::size_t(stretch.voxels.front())]);
  const double end_reach = double(lumen.depth[std::size_t(stretch.voxels.back())]);
  const double deepest = deepest_in(lumen, stretch);
  // Towards a cap the depth falls to nothing: leave out what is nearer to it than the vessel is
  // wide.
  const bool begins_at_cap = stretch.parent < 0, ends_at_cap = stretch.children.empty();
  for (const int v : stretch.voxels) {
    const Vec3 p = lumen.position(v);
    if (distance(p, begin) < (begins_at_cap ? deepest : begin_reach)) continue;
    if (distance(p, end) < (ends_at_cap ? deepest : end_reach)) continue;
    own.push_back(v);
  }
  if (!own.empty()) return own;
  const auto middle = std::max_element(
      stretch.voxels.begin(), stretch.voxels.end(),
      [&](int a, int b) { return lumen.depth[std::size_t(a)] < lumen.depth[std::size_t(b)]; });
  return {*middle};
}

double median_depth(const LumenVoxels& lumen, const std::vector<int>& voxels) {
  std::vector<float> depth;
  for (const int v : voxels) depth.push_back(lumen.depth[std::size_t(v)]);
  return double(median(std::move(depth)));
}

/// The half of a stretch that ends at a tip, without its cap; of a short one, half of which may lie
/// in a cap that is slanted, the half of what is left without the cap.
std::vector<int> outer_half(const LumenVoxels& lumen, const BranchStretch& stretch,
                            bool tip_is_first) {
  constexpr double kShort = 6.0;  // radii: of its half a third is left, without cap and middle
  const double length =
      distance(lumen.position(stretch.voxels.front()), lumen.position(stretch.voxels.back()));
  if (length < kShort * deepest_in(lumen, stretch)) {
    const std::vector<int> own = own_voxels(lumen, stretch);
    const auto half = std::ptrdiff_t((own.size() + 1) / 2);
    return tip_is_first ? std::vector<int>(own.begin(), own.begin() + half)
                        : std::vector<int>(own.end() - half, own.end());
  }
  BranchStretch half;
  const auto middle = stretch.voxels.begin() + std::ptrdiff_t(stretch.voxels.size() / 2);
  if (tip_is_first) {
    half.voxels.assign(stretch.voxels.begin(), middle + 1);
    half.children = {0};
  } else {
    half.parent = 0;
    half.voxels.assign(middle, stretch.voxels.end());
  }
  return own_voxels(lumen, half);
}

/// The direction in which a stretch leaves a fork: past the fork's own width, over as much again.
Vec3 leaving(const LumenVoxels& lumen, const std::vector<int>& from_fork) {
  const Vec3 fork = lumen.position(from_fork.front());
  const double width = double(lumen.depth[std::size_t(from_fork.front())]);
  Vec3 near = fork, far = fork;
  for (const int v : from_fork) {
    far = lumen.position(v);
    const double away = distance(far, fork);
    if (away <= width) near = far;
    if (away > 3.0 * width) break;
  }
  return normalized(distance(far, near) > 0.0 ? far - near : far - fork);
}

/// The inscribed ball around a voxel of a path.
struct PathBall {
  Vec3 center;
  double radius;
  std::size_t path, place;  ///< which path, and where on it
};

/// Balls, found by the places inside them: each lies in the cells of a grid as wide as itself.
class NestedBalls {
 public:
  void add(const PathBall& ball) {
    const int level = int(std::ceil(std::log2(std::max(ball.radius, 1e-9))));
    const Vec3 r{ball.radius, ball.radius, ball.radius};
    const Cell low = cell_of(level, ball.center - r), high = cell_of(level, ball.center + r);
    for (int k = low[3]; k <= high[3]; ++k)
      for (int j = low[2]; j <= high[2]; ++j)
        for (int i = low[1]; i <= high[1]; ++i)
          balls_of_[{level, i, j, k}].push_back(balls_.size());
    levels_.insert(level);
    balls_.push_back(ball);
  }
  /// The ball in which a place lies the deepest, by its radius; the last one among equals.
  [[nodiscard]] std::optional<PathBall> innermost(const Vec3& place) const {
    std::pair<double, std::size_t> best{1.0, 0};
    bool is_in_one = false;
    for (const int level : levels_) {
      const auto at = balls_of_.find(cell_of(level, place));
      if (at == balls_of_.end()) continue;
      for (const std::size_t b : at->second) {
        const double ratio = distance(place, balls_[b].center) / std::max(balls_[b].radius, 1e-9);
        if (ratio > best.first || (ratio == best.first && is_in_one && b < best.second)) continue;
        best = {ratio, b};
        is_in_one = true;
      }
    }
    return is_in_one ? std::optional(balls_[best.second]) : std::nullopt;
  }

 private:
  using Cell = std::array<int, 4>;  ///< level, i, j, k; of a width of 2^level mm
  [[nodiscard]] static Cell cell_of(int level, const Vec3& place) {
    const Vec3 at = std::ldexp(1.0, -level) * place;
    return {level, int(std::floor(at.x)), int(std::floor(at.y)), int(std::floor(at.z))};
  }
  std::vector<PathBall> balls_;
  std::set<int> levels_;
  std::map<Cell, std::vector<std::size_t>> balls_of_;
};

/// Lets paths part where their vessels do. In a wide vessel two paths may run side by side from
/// their root on; here a path goes with those before it as long as it is within the inscribed balls
/// around them, and on its own from where it first leaves them. Paths that part so never meet
/// again.
std::vector<std::vector<int>> part_with_the_vessels(const LumenVoxels& lumen,
                                                    const std::vector<std::vector<int>>& paths) {
  std::vector<std::vector<int>> parted(paths.size());
  std::vector<std::size_t> order(paths.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return paths[a].size() > paths[b].size(); });
  NestedBalls balls;
  for (const std::size_t p : order) {
    const std::vector<int>& path = paths[p];
    std::size_t own = 0;
    std::optional<PathBall> last;
    for (; own + 1 < path.size(); ++own) {
      const std::optional<PathBall> nearest = balls.innermost(lumen.position(path[own]));
      if (!nearest) break;
      last = nearest;
    }
    std::vector<int>& result = parted[p];
    std::size_t shared = 0;
    if (last) {
      const std::vector<int>& with = parted[last->path];
      shared = last->place + 1;
      result.assign(with.begin(), with.begin() + std::ptrdiff_t(shared));
    } else {
      own = 0;
    }
    result.insert(result.end(), path.begin() + std::ptrdiff_t(own), path.end());
    for (std::size_t i = shared; i < result.size(); ++i)
      balls.add({lumen.position(result[i]), double(lumen.depth[std::size_t(result[i])]), p, i});
  }
  return parted;
}

/// The stretches of the union of paths from the root, which part once and never meet again.
std::vector<BranchStretch> find_stretches(const LumenVoxels& lumen,
                                          const std::vector<std::vector<int>>& paths,
                                          std::vector<int>& last_of_path) {
  std::vector<int> count(std::size_t(lumen.count()), 0);
  for (const auto& path : paths)
    for (const int v : path) ++count[std::size_t(v)];
  std::vector<int> stretch_of(std::size_t(lumen.count()), -1);
  std::vector<BranchStretch> stretches;
  for (const auto& path : paths) {
    int current = -1;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const auto v = std::size_t(path[i]);
      if (stretch_of[v] >= 0) {
        current = stretch_of[v];
        continue;
      }
      if (i == 0 || count[v] != count[std::size_t(path[i - 1])] || current < 0) {
        BranchStretch next;
        next.parent = current;
        if (current >= 0) {
          stretches[std::size_t(current)].children.push_back(int(stretches.size()));
          next.voxels.push_back(path[i - 1]);
        }
        current = int(stretches.size());
        stretches.push_back(std::move(next));
      }
      stretch_of[v] = current;
      stretches[std::size_t(current)].voxels.push_back(path[i]);
    }
    last_of_path.push_back(current);
  }
  for (BranchStretch& stretch : stretches) {
    const std::vector<int> own = own_voxels(lumen, stretch);
    stretch.radius = median_depth(lumen, own);
    stretch.is_stub = own.size() == 1;
    stretch.at_begin = leaving(lumen, stretch.voxels);
    std::vector<int> backward(stretch.voxels.rbegin(), stretch.voxels.rend());
    stretch.at_end = leaving(lumen, backward);
  }
  return stretches;
}

/// An arm of a fork, as seen from it.
struct Arm {
  double radius;
  Vec3 direction;
};

/// The angle at which a daughter of radius `r` leaves the line of its parent when the fork takes
/// the least work (Murray, J Gen Physiol 9:835, 1926); `rest` is the radius of all other daughters
/// as one.
double angle_of_least_work(double parent, double r, double rest) {
  const double cosine =
      (std::pow(parent, 4) + std::pow(r, 4) - std::pow(rest, 4)) / (2.0 * parent * parent * r * r);
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

/// How far blood that comes in by one radius is from what leaves by others; `cubes` is the sum of
/// their cubes (Murray, PNAS 12:207, 1926).
double misfit_cost(double in, double cubes) {
  constexpr double kMurray = 3.0;
  const double misfit = std::log(std::pow(in, 3) / cubes);
  return kMurray * misfit * misfit;
}

double fork_cost(const Arm& in, const std::vector<Arm>& out) {
  constexpr double kAngle = 3.0, kMost = 3.0;
  double cubes = 0.0;
  for (const Arm& arm : out) cubes += std::pow(arm.radius, 3);
  double angles = 0.0;
  for (const Arm& arm : out) {
    const double rest = std::cbrt(std::max(cubes - std::pow(arm.radius, 3), 0.0));
    const double turn = std::acos(std::clamp(-dot(in.direction, arm.direction), -1.0, 1.0));
    const double off = turn - angle_of_least_work(std::cbrt(cubes), arm.radius, rest);
    angles += off * off / double(out.size());
  }
  return std::min(misfit_cost(in.radius, cubes) + kAngle * angles, kMost);
}

/// The costs of all forks when blood comes from the far end of stretch `inlet` (-1: the root).
double tree_cost(const std::vector<BranchStretch>& stretches, int inlet) {
  std::vector<char> is_reversed(stretches.size(), 0);
  for (int s = inlet; s >= 0; s = stretches[std::size_t(s)].parent) is_reversed[std::size_t(s)] = 1;
  double cost = 0.0;
  for (const BranchStretch& stretch : stretches) {
    if (stretch.children.empty()) continue;
    const Arm own{stretch.radius, stretch.at_end};
    Arm in = own;
    std::vector<Arm> out;
    const int from = [&] {
      for (const int c : stretch.children)
        if (is_reversed[std::size_t(c)] != 0) return c;
      return -1;
    }();
    if (from >= 0) out.push_back(own);
    for (const int c : stretch.children) {
      const BranchStretch& child = stretches[std::size_t(c)];
      const Arm arm{child.radius, child.at_begin};
      if (c == from)
        in = arm;
      else
        out.push_back(arm);
    }
    cost += fork_cost(in, out);
  }
  return cost;
}

/// The voxels between the ends of two paths from the root; an empty path: the root itself.
std::vector<int> path_between(const std::vector<int>& a, const std::vector<int>& b) {
  std::size_t shared = 0;
  while (shared < a.size() && shared < b.size() && a[shared] == b[shared]) ++shared;
  const std::size_t first = shared > 0 ? shared - 1 : 0;
  std::vector<int> between(a.rbegin(), a.rend() - std::ptrdiff_t(std::min(first, a.size())));
  between.insert(between.end(), b.begin() + std::ptrdiff_t(std::min(shared, b.size())), b.end());
  return between;
}

/// The place on a path that is the farthest by a measure, and the way to it [mm].
template <class Measure>
std::pair<Vec3, double> farthest_on(const LumenVoxels& lumen, const std::vector<int>& path,
                                    const Measure& measure) {
  Vec3 last = lumen.position(path.front());
  std::pair<Vec3, double> farthest{last, 0.0};
  double length = 0.0;
  for (const int v : path) {
    const Vec3 p = lumen.position(v);
    length += distance(p, last);
    last = p;
    if (measure(p) > measure(farthest.first)) farthest = {p, length};
  }
  return farthest;
}

double length_of(const LumenVoxels& lumen, const std::vector<int>& path) {
  double length = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    length += distance(lumen.position(path[i - 1]), lumen.position(path[i]));
  return length;
}

/// The lengths [mm] of the two limbs of an arch, from its ends to its top; nothing of a path that
/// is none. Both limbs are seen from what is farthest from the straight line between the ends; the
/// top is what is farthest up, against the middle of both views.
std::optional<std::array<double, 2>> limbs_of_arch(const LumenVoxels& lumen,
                                                   const std::vector<int>& path) {
  constexpr double kLeastRadius = 5.0;                     // [mm]; a child's aorta has it
  constexpr double kLeastLimb = 3.0, kLeastCosine = 0.25;  // radii; of the angle between the limbs
  if (path.size() < 3) return {};
  const double radius = median_depth(lumen, path);
  if (radius < kLeastRadius) return {};
  const Vec3 begin = lumen.position(path.front()), end = lumen.position(path.back());
  const Vec3 chord = normalized(end - begin);
  const auto [shoulder, ignored] =
      farthest_on(lumen, path, [&](const Vec3& p) { return norm(cross(p - begin, chord)); });
  const Vec3 to_begin = normalized(begin - shoulder), to_end = normalized(end - shoulder);
  if (std::min(distance(begin, shoulder), distance(end, shoulder)) < kLeastLimb * radius ||
      dot(to_begin, to_end) < kLeastCosine)
    return {};
  const Vec3 up = -normalized(to_begin + to_end);
  const double limb = farthest_on(lumen, path, [&](const Vec3& p) { return dot(p, up); }).second;
  return std::array{limb, length_of(lumen, path) - limb};
}

}  // namespace

InletChoice choose_inlet(const LumenVoxels& lumen, const Front& front,
                         const std::vector<InletCandidate>& candidates) {
  constexpr double kWide = 2.0, kCutOff = 1.25, kMostOfTree = 6.0, kFlared = 1.5;
  constexpr double kLongerLimb = 1.25, kArch = 2.0;
  std::vector<std::vector<int>> paths;
  for (std::size_t c = 1; c < candidates.size(); ++c)
    paths.push_back(trace(front, candidates[c].voxel));
  paths = part_with_the_vessels(lumen, paths);
  std::vector<int> last{-1};
  std::vector<BranchStretch> stretches = find_stretches(lumen, paths, last);
  if (stretches.empty()) return {};
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    BranchStretch& stretch = stretches[last[c] < 0 ? 0 : std::size_t(last[c])];
    if (stretch.is_stub) stretch.radius = std::min(stretch.radius, candidates[c].opening);
  }
  // Of one vessel with two rims these tell its width; half of it may be narrowed.
  const bool is_one_vessel =
      stretches.size() == 1 && std::all_of(candidates.begin(), candidates.end(),
                                           [](const auto& c) { return std::isfinite(c.opening); });
  // A rim is wider than its vessel where it is flared, or cut aslant: up to `flared` times.
  const auto radius_up_to = [&](double flared, std::size_t c) {
    if (is_one_vessel) return candidates[c].opening;
    const BranchStretch& stretch = stretches[last[c] < 0 ? 0 : std::size_t(last[c])];
    const double own = stretch.is_stub
                           ? stretch.radius
                           : median_depth(lumen, outer_half(lumen, stretch, last[c] < 0));
    const double opening = candidates[c].opening;
    return (candidates[c].is_cut_off ? kCutOff : 1.0) * (opening < flared * own ? opening : own);
  };
  const auto radius_at = [&](std::size_t c) { return radius_up_to(kFlared, c); };
  constexpr double kSure = 1.0, kWiderThanOpen = 1.25;
  double widest_open = 0.0;
  for (std::size_t c = 0; c < candidates.size(); ++c)
    if (candidates[c].is_open && !candidates[c].is_tip)
      widest_open = std::max(widest_open, radius_up_to(1.0, c));
  double cubes = 0.0;
  for (std::size_t c = 0; c < candidates.size(); ++c) cubes += std::pow(radius_at(c), 3);
  const auto forks = std::count_if(stretches.begin(), stretches.end(),
                                   [](const BranchStretch& s) { return !s.children.empty(); });
  const double share_of_tree = forks == 1 ? 0.5 : 1.0;  // of one fork it is that one again
  std::vector<std::pair<double, std::size_t>> costs;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    if (!candidates[c].is_open) continue;
    if (candidates[c].is_tip && radius_at(c) < kWiderThanOpen * widest_open) continue;
    const double radius = radius_at(c);
    // The tree as a whole is a fork, too, and aneurysms at its forks do not change that one.
    const double others = std::max(cubes - std::pow(radius, 3), 1e-6 * cubes);
    const double as_one_fork = std::min(misfit_cost(radius, others), kMostOfTree);
    costs.emplace_back(
        tree_cost(stretches, last[c]) + share_of_tree * as_one_fork - kWide * std::log(radius), c);
  }
  if (costs.empty()) return {};
  std::stable_sort(costs.begin(), costs.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  if (costs.size() > 1) {
    const auto path_to = [&](std::size_t c) { return c == 0 ? std::vector<int>() : paths[c - 1]; };
    auto &one = costs[0], &other = costs[1];
    const auto limbs =
        limbs_of_arch(lumen, path_between(path_to(one.second), path_to(other.second)));
    if (limbs && (*limbs)[0] > kLongerLimb * (*limbs)[1]) one.first += kArch;
    if (limbs && (*limbs)[1] > kLongerLimb * (*limbs)[0]) other.first += kArch;
    std::stable_sort(costs.begin(), costs.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
  }
  InletChoice choice{costs[0].second, {}};
  if (costs.size() > 1 && costs[1].first - costs[0].first < kSure) choice.rival = costs[1].second;
  return choice;
}

}  // namespace angio::centerline

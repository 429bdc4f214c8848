#include "centerline/detail/fronts.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "centerline/detail/monotone_queue.hpp"

namespace angio::centerline {
namespace {

/// Union-find over voxels, by the maximum of each piece.
class Pieces {
 public:
  explicit Pieces(std::size_t count) : parent_(count, -1), top_(count, -1) {}
  void add(int v) { parent_[std::size_t(v)] = top_[std::size_t(v)] = v; }
  [[nodiscard]] bool has(int v) const { return parent_[std::size_t(v)] >= 0; }
  int find(int v) {
    while (parent_[std::size_t(v)] != v) {
      parent_[std::size_t(v)] = parent_[std::size_t(parent_[std::size_t(v)])];
      v = parent_[std::size_t(v)];
    }
    return v;
  }
  [[nodiscard]] int top(int root) const { return top_[std::size_t(root)]; }
  void join(int root, int into) { parent_[std::size_t(root)] = into; }

 private:
  std::vector<int> parent_, top_;
};

std::vector<int> in_falling_order(const std::vector<double>& values) {
  std::vector<int> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const double va = values[std::size_t(a)], vb = values[std::size_t(b)];
    return va != vb ? va > vb : a < b;
  });
  return order;
}

constexpr double kFar = std::numeric_limits<double>::infinity();

/// Cells between a voxel and each of its neighbours.
std::array<int, kNeighborCount> cell_steps(const LumenVoxels& lumen) {
  std::array<int, kNeighborCount> to{};
  for (std::size_t n = 0; n < to.size(); ++n) {
    const auto& o = neighbor_offsets()[n];
    to[n] = (o[2] * lumen.size[1] + o[1]) * lumen.size[0] + o[0];
  }
  return to;
}

double step_cost(double length, float depth, float next_depth) {
  const double mean_depth = 0.5 * double(depth + next_depth);
  return length / (mean_depth * mean_depth);
}

/// Moves the front on from what is in the queue.
void spread(const LumenVoxels& lumen, MonotoneQueue& queue, Front& front) {
  const auto step = neighbor_lengths(lumen.geometry);
  const std::array<int, kNeighborCount> to = cell_steps(lumen);
  std::vector<double>& cost = front.cost;
  while (!queue.empty()) {
    const auto [here, v] = queue.take();
    if (here > cost[std::size_t(v)]) continue;
    const float own_depth = lumen.depth[std::size_t(v)];
    const double own_length = front.length[std::size_t(v)];
    // First all that lies far away in memory, so that the processor waits for it once.
    std::array<int, kNeighborCount> direction, beside;
    std::array<float, kNeighborCount> depth;
    std::array<double, kNeighborCount> known;
    std::size_t count = 0;
    for (std::uint32_t links = lumen.links[std::size_t(v)]; links != 0; links &= links - 1) {
      const int n = std::countr_zero(links);
      direction[count] = n;
      beside[count++] =
          lumen.voxel_of_cell[std::size_t(lumen.cell[std::size_t(v)] + to[std::size_t(n)])];
    }
    for (std::size_t k = 0; k < count; ++k) {
      depth[k] = lumen.depth[std::size_t(beside[k])];
      known[k] = cost[std::size_t(beside[k])];
    }
    for (std::size_t k = 0; k < count; ++k) {
      const double length = step[std::size_t(direction[k])];
      const double candidate = here + step_cost(length, own_depth, depth[k]);
      if (candidate >= known[k]) continue;
      const auto w = std::size_t(beside[k]);
      cost[w] = candidate;
      front.length[w] = own_length + length;
      front.previous[w] = v;
      queue.add(candidate, beside[k]);
    }
  }
}

/// The voxels whose path runs over a link that is no more: 1, shape [voxel].
std::vector<char> lost_voxels(const LumenVoxels& lumen, const Front& front) {
  constexpr char kUnknown = 2;
  const std::array<int, kNeighborCount> to = cell_steps(lumen);
  std::vector<char> lost(front.previous.size(), kUnknown);
  const auto is_linked = [&](int v, int before) {
    const int away = lumen.cell[std::size_t(before)] - lumen.cell[std::size_t(v)];
    const auto n = std::find(to.begin(), to.end(), away) - to.begin();
    return (lumen.links[std::size_t(v)] >> n & 1U) != 0;
  };
  std::vector<int> way;
  for (int start = 0; start < lumen.count(); ++start) {
    way.clear();
    int v = start;
    for (; lost[std::size_t(v)] == kUnknown; v = front.previous[std::size_t(v)]) {
      way.push_back(v);
      if (front.previous[std::size_t(v)] < 0) break;  // the source, or cut off all round
    }
    char is_lost = lost[std::size_t(v)] == 1;
    for (auto w = way.rbegin(); w != way.rend(); ++w) {
      const int before = front.previous[std::size_t(*w)];
      if (before >= 0 && !is_linked(*w, before)) is_lost = 1;
      lost[std::size_t(*w)] = is_lost;
    }
  }
  return lost;
}

}  // namespace

Front march(const LumenVoxels& lumen, int source) {
  Front front;
  front.cost.assign(std::size_t(lumen.count()), kFar);
  front.length = front.cost;
  front.previous.assign(std::size_t(lumen.count()), -1);
  front.cost[std::size_t(source)] = front.length[std::size_t(source)] = 0.0;
  MonotoneQueue queue;
  queue.add(0.0, source);
  spread(lumen, queue, front);
  return front;
}

void march_round_cuts(const LumenVoxels& lumen, Front& front) {
  const std::vector<char> lost = lost_voxels(lumen, front);
  for (std::size_t v = 0; v < lost.size(); ++v)
    if (lost[v] != 0) {
      front.cost[v] = front.length[v] = kFar;
      front.previous[v] = -1;
    }
  // What is kept beside them is where they are reached from, the nearest first.
  const auto step = neighbor_lengths(lumen.geometry);
  MonotoneQueue queue;
  for (int v = 0; v < lumen.count(); ++v) {
    if (lost[std::size_t(v)] == 0) continue;
    for (int n = 0; n < kNeighborCount; ++n) {
      const int w = lumen.neighbor(v, n);
      if (w < 0 || lost[std::size_t(w)] != 0 || !(front.cost[std::size_t(w)] < kFar)) continue;
      const double length = step[std::size_t(n)];
      const double candidate =
          front.cost[std::size_t(w)] +
          step_cost(length, lumen.depth[std::size_t(w)], lumen.depth[std::size_t(v)]);
      double& cost = front.cost[std::size_t(v)];
      int& before = front.previous[std::size_t(v)];
      const bool is_nearer = candidate == cost && before >= 0 &&
                             front.cost[std::size_t(w)] < front.cost[std::size_t(before)];
      if (!(candidate < cost) && !is_nearer) continue;
      cost = candidate;
      front.length[std::size_t(v)] = front.length[std::size_t(w)] + length;
      before = w;
    }
    if (front.previous[std::size_t(v)] >= 0) queue.add(front.cost[std::size_t(v)], v);
  }
  spread(lumen, queue, front);
}

std::vector<int> trace(const Front& front, int target) {
  std::vector<int> path;
  for (int v = target; v >= 0; v = front.previous[std::size_t(v)]) path.push_back(v);
  std::reverse(path.begin(), path.end());
  return path;
}

std::vector<LumenEnd> find_maxima(const LumenVoxels& lumen, const Front& front,
                                  double least_prominence) {
  const std::vector<double>& length = front.length;
  const std::vector<int> order = in_falling_order(length);
  const auto higher = [&](int a, int b) {
    const double la = length[std::size_t(a)], lb = length[std::size_t(b)];
    return la != lb ? la > lb : a < b;
  };
  Pieces pieces(length.size());
  std::vector<LumenEnd> ends;
  int farthest = -1;
  for (const int v : order) {
    if (std::isinf(length[std::size_t(v)])) continue;  // cut off all round
    if (farthest < 0) farthest = v;
    int home = -1;
    for (int n = 0; n < kNeighborCount; ++n) {
      const int w = lumen.neighbor(v, n);
      if (w < 0 || !pieces.has(w)) continue;
      int root = pieces.find(w);
      if (home < 0) {
        pieces.add(v);
        pieces.join(v, root);
        home = root;
        continue;
      }
      if (root == home) continue;
      if (higher(pieces.top(root), pieces.top(home))) std::swap(root, home);
      const int tip = pieces.top(root);
      const double prominence = length[std::size_t(tip)] - length[std::size_t(v)];
      if (prominence >= least_prominence) ends.push_back({tip, prominence});
      pieces.join(root, home);
    }
    if (home < 0) pieces.add(v);
  }
  if (farthest >= 0) ends.push_back({farthest, length[std::size_t(farthest)]});
  std::sort(ends.begin(), ends.end(), [](const LumenEnd& a, const LumenEnd& b) {
    return a.prominence != b.prominence ? a.prominence > b.prominence : a.voxel < b.voxel;
  });
  return ends;
}

}  // namespace angio::centerline

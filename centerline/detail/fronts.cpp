#include "centerline/detail/fronts.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>

#include "centerline/detail/monotone_queue.hpp"
#include "core/parallel.hpp"

namespace angio::centerline {
namespace {

/// Union-find over basins, by the maximum of each piece.
class Pieces {
 public:
  explicit Pieces(std::size_t voxel_count) : parent_(voxel_count, -1) {}
  /// The maximum of the piece that a basin is in. @param top  a basin's own maximum
  int find(int top) {
    int root = top;
    while (parent_[std::size_t(root)] >= 0) root = parent_[std::size_t(root)];
    while (top != root) top = std::exchange(parent_[std::size_t(top)], root);
    return root;
  }
  void join(int top, int into) { parent_[std::size_t(top)] = into; }

 private:
  std::vector<int> parent_;
};

/// Voxels by the length of their paths, farther first; among equals the first one.
struct Farther {
  const std::vector<double>& length;
  bool operator()(int a, int b) const {
    const double la = length[std::size_t(a)], lb = length[std::size_t(b)];
    return la != lb ? la > lb : a < b;
  }
};

/// The maximum that is reached from each voxel by going on to its farthest neighbour; itself where
/// the voxel is cut off. Shape [voxel].
std::vector<int> find_basins(const LumenVoxels& lumen, const Front& front) {
  const std::vector<double>& length = front.length;
  const Farther farther{length};
  std::vector<int> top(length.size());
  parallel_for(lumen.count(), [&](std::ptrdiff_t v) {
    int best = int(v);
    for (int n = 0; n < kNeighborCount; ++n) {
      const int w = lumen.neighbor(int(v), n);
      if (w >= 0 && !std::isinf(length[std::size_t(w)]) && farther(w, best)) best = w;
    }
    top[std::size_t(v)] = best;
  });
  std::vector<int> way;
  for (int v = 0; v < lumen.count(); ++v) {
    int w = v;
    for (way.clear(); top[std::size_t(w)] != w; w = top[std::size_t(w)]) way.push_back(w);
    for (const int on_way : way) top[std::size_t(on_way)] = w;
  }
  return top;
}

/// Where two basins meet: the farthest voxel that has a neighbour in the other one that is not
/// nearer.
struct Saddle {
  int voxel;
  int tops[2];
};

/// The saddles between basins, the farthest first.
std::vector<Saddle> find_saddles(const LumenVoxels& lumen, const Front& front,
                                 const std::vector<int>& top) {
  const Farther farther{front.length};
  using SaddleOf = std::unordered_map<std::uint64_t, int>;  // by the pair of tops
  const auto put = [&](SaddleOf& saddle_of, std::uint64_t pair, int voxel) {
    const auto [at, is_new] = saddle_of.try_emplace(pair, voxel);
    if (!is_new && farther(voxel, at->second)) at->second = voxel;
  };
  constexpr int kBlock = 1 << 15;  // voxels
  std::vector<SaddleOf> of_block(std::size_t(lumen.count() / kBlock) + 1);
  parallel_for_uneven(std::ptrdiff_t(of_block.size()), [&](std::ptrdiff_t block) {
    const int begin = int(block) * kBlock, end = std::min(begin + kBlock, lumen.count());
    for (int v = begin; v < end; ++v) {
      if (std::isinf(front.length[std::size_t(v)])) continue;
      for (int n = 0; n < kNeighborCount / 2; ++n) {  // each pair once
        const int w = lumen.neighbor(v, n);
        if (w < 0 || top[std::size_t(w)] == top[std::size_t(v)] ||
            std::isinf(front.length[std::size_t(w)]))
          continue;
        const auto [a, b] = std::minmax(top[std::size_t(v)], top[std::size_t(w)]);
        put(of_block[std::size_t(block)], std::uint64_t(a) << 32 | std::uint64_t(b),
            farther(v, w) ? w : v);
      }
    }
  });
  SaddleOf saddle_of;
  for (const SaddleOf& some : of_block)
    for (const auto& [pair, voxel] : some) put(saddle_of, pair, voxel);
  std::vector<Saddle> saddles;
  for (const auto& [pair, voxel] : saddle_of)
    saddles.push_back({voxel, {int(pair >> 32), int(pair & 0xffffffffU)}});
  std::sort(saddles.begin(), saddles.end(), [&](const Saddle& a, const Saddle& b) {
    return a.voxel != b.voxel
               ? farther(a.voxel, b.voxel)
               : std::lexicographical_compare(a.tops, a.tops + 2, b.tops, b.tops + 2);
  });
  return saddles;
}

constexpr double kFar = std::numeric_limits<double>::infinity();

/// Cells between a voxel and each of its neighbours.
std::array<int, kNeighborCount> cell_steps(const LumenVoxels& lumen) {
  std::array<int, kNeighborCount> to{};
  for (std::size_t n = 0; n < to.size(); ++n) {
    const auto& o = kNeighborOffsets[n];
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
  const Farther farther{length};
  const std::vector<int> top = find_basins(lumen, front);
  Pieces pieces(length.size());
  std::vector<LumenEnd> ends;
  for (const Saddle& saddle : find_saddles(lumen, front, top)) {
    int low = pieces.find(saddle.tops[0]), high = pieces.find(saddle.tops[1]);
    if (low == high) continue;
    if (farther(low, high)) std::swap(low, high);
    const double prominence = length[std::size_t(low)] - length[std::size_t(saddle.voxel)];
    if (prominence >= least_prominence) ends.push_back({low, prominence});
    pieces.join(low, high);
  }
  int farthest = -1;
  for (const int v : top)
    if (!std::isinf(length[std::size_t(v)]) && (farthest < 0 || farther(v, farthest))) farthest = v;
  if (farthest >= 0) ends.push_back({farthest, length[std::size_t(farthest)]});
  std::sort(ends.begin(), ends.end(), [](const LumenEnd& a, const LumenEnd& b) {
    return a.prominence != b.prominence ? a.prominence > b.prominence : a.voxel < b.voxel;
  });
  return ends;
}

}  // namespace angio::centerline

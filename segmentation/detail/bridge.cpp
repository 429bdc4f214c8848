#include "segmentation/detail/bridge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_map>
#include <utility>

#include "core/parallel.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"

namespace angio::segmentation::detail {
namespace {

/// [mm] along the axes; a longer gap is no narrow place but a hole. 5 sqrt(3): join_across_gaps
constexpr double kLongestBridge = 9.0;
constexpr float kBridgeLevel = -0.1f;
constexpr double kOutsideCost = 8.0;  ///< of a step through pure background, against lumen

/// What the search knows of a voxel.
struct Reached {
  double cost;
  double length;       ///< from the start [mm]
  std::size_t before;  ///< the voxel it was reached from; itself at the start
};

/// Grows what is joined already from piece to piece, each time to the one that is cheapest to reach
/// through the tree.
class BridgeSearch {
 public:
  BridgeSearch(const Volume<float>& level, const Volume<std::uint8_t>& tree,
               const std::vector<std::int32_t>& label, const std::vector<bool>& worthy)
      : level_(level), tree_(tree), label_(label), is_joined_(worthy.size(), false) {
    for (bool is_worthy : worthy) piece_.emplace_back(is_worthy);
    for (std::size_t v = 0; v < label.size(); ++v) {
      const auto piece = std::size_t(label[v]);
      if (worthy[piece] && tree.values[v]) piece_[piece].voxels.push_back(v);
    }
  }

  /// Takes a piece in.
  void join(std::int32_t label) {
    is_joined_[std::size_t(label)] = true;
    for (std::size_t v : piece_[std::size_t(label)].voxels) reach(v, {0.0, 0.0, v});
  }

  [[nodiscard]] bool is_joined(std::int32_t label) const { return is_joined_[std::size_t(label)]; }

  /// The way to the nearest piece, from it on; it is made part of what is joined, as is the piece.
  /// Empty if there is none.
  std::vector<std::size_t> next_way() {
    while (!queue_.empty()) {
      const auto [cost, v] = queue_.top();
      queue_.pop();
      const Reached here = reached_.at(v);
      if (cost > here.cost) continue;
      const std::int32_t label = label_[v];
      if (piece_[std::size_t(label)].is_worthy && !is_joined_[std::size_t(label)]) {
        std::vector<std::size_t> way = way_to(v);
        for (std::size_t w : way) reach(w, {0.0, 0.0, w});
        join(label);
        return way;
      }
      step_on(v, here);
    }
    return {};
  }

 private:
  using Entry = std::pair<double, std::size_t>;
  struct Piece {
    bool is_worthy;
    std::vector<std::size_t> voxels;  ///< of the tree in it
    explicit Piece(bool worthy) : is_worthy(worthy) {}
  };

  void reach(std::size_t v, const Reached& reached) {
    const auto [entry, is_new] = reached_.try_emplace(v, reached);
    if (!is_new) {
      if (entry->second.cost <= reached.cost) return;
      entry->second = reached;
    }
    queue_.emplace(reached.cost, v);
  }

  void step_on(std::size_t v, const Reached& here) {
    const auto& g = level_.geometry;
    const auto ni = std::size_t(g.size[0]), nj = std::size_t(g.size[1]);
    const std::array<int, 3> voxel{int(v % ni), int(v / ni % nj), int(v / ni / nj)};
    for (int axis = 0; axis < 3; ++axis)
      for (int side : {-1, 1}) {
        auto next = voxel;
        next[std::size_t(axis)] += side;
        if (!g.contains(next[0], next[1], next[2])) continue;
        const std::size_t n = g.offset(next[0], next[1], next[2]);
        if (!tree_.values[n] || is_joined_[std::size_t(label_[n])]) continue;
        const double length = here.length + g.spacing[axis];
        if (length > kLongestBridge) continue;
        const double outside = std::max(double(level_.values[n]), 0.0);
        reach(n, {here.cost + g.spacing[axis] * (1.0 + kOutsideCost * outside), length, v});
      }
  }

  [[nodiscard]] std::vector<std::size_t> way_to(std::size_t v) const {
    std::vector<std::size_t> way{v};
    while (reached_.at(v).before != v) way.push_back(v = reached_.at(v).before);
    return way;
  }

  const Volume<float>& level_;
  const Volume<std::uint8_t>& tree_;
  const std::vector<std::int32_t>& label_;
  std::vector<Piece> piece_;
  std::vector<bool> is_joined_;
  std::unordered_map<std::size_t, Reached> reached_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace

std::vector<Vec3> bridge_pieces(Volume<float>& level, const Volume<std::uint8_t>& tree,
                                double least_volume, bool are_several) {
  Volume<std::uint8_t> inside(level.geometry);
  for (std::size_t v = 0; v < level.values.size(); ++v) inside.values[v] = level.values[v] < 0.0f;
  const Components pieces = label_components(inside, Connectivity::faces);
  const Vec3& h = level.geometry.spacing;
  std::vector<std::size_t> overlap(std::size_t(pieces.count()) + 1, 0);
  for (std::size_t v = 0; v < level.values.size(); ++v)
    if (tree.values[v] && pieces.label[v] > 0) ++overlap[std::size_t(pieces.label[v])];
  std::vector<bool> worthy;
  for (std::size_t count : overlap)
    worthy.push_back(count > 0 && double(count) * h.x * h.y * h.z >= least_volume);

  std::vector<Vec3> middles;
  BridgeSearch search(level, tree, pieces.label, worthy);
  const auto join_largest = [&] {
    std::int32_t largest = -1;
    for (std::int32_t p = 1; p <= pieces.count(); ++p)
      if (!search.is_joined(p) &&
          (largest < 0 || overlap[std::size_t(p)] > overlap[std::size_t(largest)]))
        largest = p;
    if (largest > 0) search.join(largest);
  };
  join_largest();
  for (auto left = std::count(worthy.begin(), worthy.end(), true); left > 1; --left) {
    const auto way = search.next_way();
    if (way.empty() && !are_several) break;
    if (way.empty()) {
      join_largest();
      continue;
    }
    for (std::size_t v : way) level.values[v] = std::min(level.values[v], kBridgeLevel);
    middles.push_back(place_of_voxel(level.geometry, way[way.size() / 2]));
  }
  return middles;
}

std::vector<std::size_t> tree_in_pieces(const Pieces& pieces, const Volume<std::uint8_t>& tree,
                                        const std::array<int, 3>& ratio) {
  std::vector<std::size_t> count(std::size_t(pieces.count()) + 1, 0);
  for (const Pieces::Run& run : pieces.runs) {
    const std::uint8_t* row =
        &tree.at(0, (run.j + ratio[1] / 2) / ratio[1], (run.k + ratio[2] / 2) / ratio[2]);
    for (int i = run.first; i < run.last; ++i)
      count[std::size_t(run.label)] += row[(i + ratio[0] / 2) / ratio[0]];
  }
  return count;
}

Volume<std::uint8_t> refine_mask(const Volume<std::uint8_t>& mask, const VolumeGeometry& geometry,
                                 const std::array<int, 3>& ratio) {
  Volume<std::uint8_t> result(geometry);
  parallel_for(geometry.size[2], [&](std::ptrdiff_t k) {
    for (int j = 0; j < geometry.size[1]; ++j) {
      const std::uint8_t* row =
          &mask.at(0, (j + ratio[1] / 2) / ratio[1], (int(k) + ratio[2] / 2) / ratio[2]);
      std::uint8_t* out = &result.at(0, j, int(k));
      for (int i = 0; i < geometry.size[0]; ++i) out[i] = row[(i + ratio[0] / 2) / ratio[0]];
    }
  });
  return result;
}

}  // namespace angio::segmentation::detail

#include "segmentation/detail/signed_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "core/parallel.hpp"
#include "segmentation/detail/far_distance.hpp"
#include "segmentation/detail/patch.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kBandVoxels = 4.0;  ///< distance to which closest points are found voxel by voxel
constexpr int kBrick = 32;           ///< voxels along each side that are worked on at once
constexpr float kUnreached = std::numeric_limits<float>::infinity();
using Offset = Vec3T<float>;  ///< from a voxel's centre to its closest point, along the axes [mm]

/// Weights of Catmull-Rom's cubic at t in [0, 1] and of its derivative.
struct CubicWeights {
  std::array<float, 4> value, slope;
  explicit CubicWeights(float t)
      : value{0.5f * t * (-1.0f + t * (2.0f - t)), 1.0f + 0.5f * t * t * (3.0f * t - 5.0f),
              0.5f * t * (1.0f + t * (4.0f - 3.0f * t)), 0.5f * t * t * (t - 1.0f)},
        slope{-0.5f + t * (2.0f - 1.5f * t), t * (4.5f * t - 5.0f), 0.5f + t * (4.0f - 4.5f * t),
              t * (1.5f * t - 1.0f)} {}
};

/// A value and its gradient per mm along the axes.
struct Slope {
  float value;
  Offset gradient;
};

/// Closest points of the voxels of one brick and its border.
class BrickDistance {
 public:
  /// @param refined_mm  distance to which closest points are each voxel's own, not a neighbour's
  BrickDistance(const Volume<float>& level, double reach_mm, double refined_mm)
      : level_(level), reach_(float(reach_mm)), refined_(float(refined_mm)) {
    const Vec3& h = level.geometry.spacing;
    h_ = {float(h.x), float(h.y), float(h.z)};
    border_ = 1 + int(std::ceil(reach_mm / std::min({h.x, h.y, h.z})));
  }

  /// The brick's distances, row by row; empty if the zero does not come near it.
  std::vector<float> run(const Brick& brick) {
    gather(patch_, level_, {1, 1, 1}, brick, border_);
    if (!find_first_layer()) return {};
    propagate(brick);
    refine_near(brick);
    std::vector<float> result;
    result.reserve(std::size_t(brick.size[0]) * std::size_t(brick.size[1]) *
                   std::size_t(brick.size[2]));
    for (int k = 0; k < brick.size[2]; ++k)
      for (int j = 0; j < brick.size[1]; ++j) {
        const std::size_t from = patch_.offset(border_, j + border_, k + border_);
        for (std::size_t v = from; v < from + std::size_t(brick.size[0]); ++v) {
          const float d = std::min(std::sqrt(squared_[v]), reach_);
          result.push_back(is_inside(v) ? -d : d);
        }
      }
    return result;
  }

 private:
  [[nodiscard]] bool is_inside(std::size_t v) const { return patch_.values[v] < 0.0f; }
  [[nodiscard]] std::array<int, 3> place(std::size_t v) const {
    const auto ni = std::size_t(patch_.size[0]), nj = std::size_t(patch_.size[1]);
    return {int(v % ni), int(v / ni % nj), int(v / ni / nj)};
  }
  [[nodiscard]] Slope sample(const std::array<int, 3>& voxel, const Offset& way) const;
  [[nodiscard]] Offset refine(const std::array<int, 3>& voxel, const Offset& start) const;
  bool find_changes(const float* row, std::ptrdiff_t nj, std::ptrdiff_t nk);
  bool find_first_layer();
  void propagate(const Brick& brick);
  void refine_near(const Brick& brick);

  const Volume<float>& level_;
  float reach_;
  float refined_;
  Offset h_;
  int border_;
  Patch patch_;
  std::vector<float> squared_;
  std::vector<Offset> offset_;
  std::vector<std::vector<std::uint32_t>> front_;
  std::vector<std::uint8_t> state_, changes_;
};

/// The cubic interpolant at a way [mm] from a voxel.
Slope BrickDistance::sample(const std::array<int, 3>& voxel, const Offset& way) const {
  int cell[3];
  std::array<CubicWeights, 3> weights{CubicWeights(0.0f), CubicWeights(0.0f), CubicWeights(0.0f)};
  for (int axis = 0; axis < 3; ++axis) {
    const float x = float(voxel[std::size_t(axis)]) + way[axis] / h_[axis];
    cell[axis] = std::clamp(int(std::floor(x)), 1, patch_.size[std::size_t(axis)] - 3);
    weights[std::size_t(axis)] = CubicWeights(std::clamp(x - float(cell[axis]), 0.0f, 1.0f));
  }
  Slope sum{0.0f, {}};
  for (int c = 0; c < 4; ++c) {
    Slope plane{0.0f, {}};
    for (int b = 0; b < 4; ++b) {
      const float* row = patch_.row(cell[1] - 1 + b, cell[2] - 1 + c) + cell[0] - 1;
      const auto& [wx, sx] = weights[0];
      const float value = wx[0] * row[0] + wx[1] * row[1] + wx[2] * row[2] + wx[3] * row[3];
      const float slope = sx[0] * row[0] + sx[1] * row[1] + sx[2] * row[2] + sx[3] * row[3];
      plane.value += weights[1].value[std::size_t(b)] * value;
      plane.gradient.x += weights[1].value[std::size_t(b)] * slope;
      plane.gradient.y += weights[1].slope[std::size_t(b)] * value;
    }
    sum.value += weights[2].value[std::size_t(c)] * plane.value;
    sum.gradient.x += weights[2].value[std::size_t(c)] * plane.gradient.x;
    sum.gradient.y += weights[2].value[std::size_t(c)] * plane.gradient.y;
    sum.gradient.z += weights[2].slope[std::size_t(c)] * plane.value;
  }
  for (int axis = 0; axis < 3; ++axis) sum.gradient[axis] /= h_[axis];
  return sum;
}

/// Way [mm] from a voxel to its closest point of the zero, by projecting the voxel onto the tangent
/// plane at the last estimate, twice:
///
///     y <- x - (F(y) + g . (x - y)) g / |g|^2,    g = grad F(y)
///
/// @param start  a first estimate
/// @return the start, where the iteration leaves the neighbourhood
Offset BrickDistance::refine(const std::array<int, 3>& voxel, const Offset& start) const {
  const float longest = norm(h_);  ///< that the estimate may move
  Offset way = start;
  for (int iteration = 0; iteration < 2; ++iteration) {
    const auto [value, g] = sample(voxel, way);
    const float squared = norm_squared(g);
    if (!(squared > 0.0f)) return start;
    way = (-(value - dot(g, way)) / squared) * g;
    if (!(norm(way - start) < longest)) return start;
  }
  return way;
}

/// Marks the values of a row with others of the other sign beside them. @return whether there are
/// any
bool BrickDistance::find_changes(const float* row, std::ptrdiff_t nj, std::ptrdiff_t nk) {
  const int count = patch_.size[0];
  changes_.assign(std::size_t(count), 0);
  std::uint8_t any = 0;
  for (int i = 1; i + 1 < count; ++i) {
    const float* at = row + i;
    const int inside = at[0] < 0.0f;
    const int changes = (inside ^ int(at[-1] < 0.0f)) | (inside ^ int(at[1] < 0.0f)) |
                        (inside ^ int(at[-nj] < 0.0f)) | (inside ^ int(at[nj] < 0.0f)) |
                        (inside ^ int(at[-nk] < 0.0f)) | (inside ^ int(at[nk] < 0.0f));
    changes_[std::size_t(i)] = std::uint8_t(changes);
    any = std::uint8_t(any | changes);
  }
  return any != 0;
}

/// @return false if the zero does not come near the brick
bool BrickDistance::find_first_layer() {
  squared_.assign(patch_.values.size(), kUnreached);
  offset_.resize(patch_.values.size());
  const auto [ni, nj, nk] = patch_.size;
  const std::array<std::ptrdiff_t, 3> stride{1, ni, std::ptrdiff_t(ni) * nj};
  bool is_any = false;
  for (int k = 1; k + 1 < nk; ++k)
    for (int j = 1; j + 1 < nj; ++j) {
      const float* row = patch_.row(j, k);
      if (!find_changes(row, stride[1], stride[2])) continue;
      for (int i = 1; i + 1 < ni; ++i) {
        if (!changes_[std::size_t(i)]) continue;
        const float* at = row + i;
        const bool inside = *at < 0.0f;
        Offset n;
        for (int axis = 0; axis < 3; ++axis) {
          float nearest = 0.0f;  // crossing along this axis, signed by its side [mm]
          for (int side : {-1, 1}) {
            const float there = at[side * stride[std::size_t(axis)]];
            if (inside == (there < 0.0f)) continue;
            const float way = std::max(*at / (*at - there), 1e-4f) * h_[axis];
            if (nearest == 0.0f || way < std::abs(nearest)) nearest = float(side) * way;
          }
          n[axis] = nearest == 0.0f ? 0.0f : 1.0f / nearest;
        }
        const float squared = norm_squared(n);
        if (squared == 0.0f) continue;
        const std::size_t v = patch_.offset(i, j, k);
        offset_[v] = refine({i, j, k}, n / squared);
        squared_[v] = std::max(norm_squared(offset_[v]), 1e-12f);
        is_any = true;
      }
    }
  return is_any;
}

/// Hands closest points on from near voxels to far ones, on each side of the surface by itself; not
/// from where the brick is farther than the reach.
void BrickDistance::propagate(const Brick& brick) {
  const float step = 0.25f * std::min({h_.x, h_.y, h_.z});
  front_.resize(std::size_t(reach_ / step) + 2);
  for (auto& bucket : front_) bucket.clear();
  const auto push = [&](std::size_t v, std::size_t now) {
    const auto bucket = std::max(now, std::size_t(std::sqrt(squared_[v]) / step));
    if (bucket < front_.size()) front_[bucket].push_back(std::uint32_t(v));
  };
  for (std::size_t v = 0; v < squared_.size(); ++v)
    if (squared_[v] != kUnreached) push(v, 0);
  constexpr std::uint8_t kDone = 2;  // else 1 inside, 0 outside
  state_.resize(squared_.size());
  for (std::size_t v = 0; v < state_.size(); ++v) state_[v] = is_inside(v) ? 1 : 0;
  // What a voxel hands on has come this far, and has the way to the brick before it.
  const auto is_of_use = [&](const std::array<int, 3>& at, float squared) {
    Offset way;
    for (std::size_t a = 0; a < 3; ++a) {
      const int beside = std::max({border_ - at[a], at[a] - (border_ + brick.size[a] - 1), 0});
      way[int(a)] = float(beside) * h_[int(a)];
    }
    return norm(way) + std::sqrt(squared) < reach_ + norm(h_);
  };
  struct Neighbor {
    std::ptrdiff_t stride;
    Offset way;
  };
  std::vector<Neighbor> neighbors;
  const std::ptrdiff_t nj = patch_.size[0], nk = nj * patch_.size[1];
  for (int dk = -1; dk <= 1; ++dk)
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di)
        if (di != 0 || dj != 0 || dk != 0)
          neighbors.push_back(
              {di + dj * nj + dk * nk, {float(di) * h_.x, float(dj) * h_.y, float(dk) * h_.z}});
  for (std::size_t now = 0; now < front_.size(); ++now)
    for (std::size_t n = 0; n < front_[now].size(); ++n) {
      const std::size_t v = front_[now][n];
      const std::uint8_t state = std::exchange(state_[v], kDone);
      if (state == kDone) continue;
      const auto at = place(v);
      if (at[0] < 1 || at[1] < 1 || at[2] < 1 || at[0] + 1 >= patch_.size[0] ||
          at[1] + 1 >= patch_.size[1] || at[2] + 1 >= patch_.size[2])
        continue;
      if (!is_of_use(at, squared_[v])) continue;
      const Offset here = offset_[v];
      for (const Neighbor& neighbor : neighbors) {
        const auto other = std::size_t(std::ptrdiff_t(v) + neighbor.stride);
        if (state_[other] != state) continue;
        const Offset way = here - neighbor.way;
        const float squared = norm_squared(way);
        if (squared >= squared_[other]) continue;
        squared_[other] = squared;
        offset_[other] = way;
        push(other, now);
      }
    }
}

/// A point handed on is the closest of a neighbour; near the surface it is moved to a voxel's own.
void BrickDistance::refine_near(const Brick& brick) {
  for (int k = border_; k < border_ + brick.size[2]; ++k)
    for (int j = border_; j < border_ + brick.size[1]; ++j)
      for (int i = border_; i < border_ + brick.size[0]; ++i) {
        const std::size_t v = patch_.offset(i, j, k);
        if (!(squared_[v] < refined_ * refined_)) continue;
        const Offset way = refine({i, j, k}, offset_[v]);
        // Both are way-points of the zero; one that misses it by little of the way is on it.
        const float missed = std::abs(sample({i, j, k}, way).value);
        if (missed <= 0.02f * std::abs(patch_.values[v]) ||
            missed <= std::abs(sample({i, j, k}, offset_[v]).value))
          squared_[v] = norm_squared(way);
      }
}

/// Which signs a level has, in cells of a grid.
class SignCells {
 public:
  explicit SignCells(const Volume<float>& level) : size_(level.geometry.size) {
    for (std::size_t a = 0; a < 3; ++a) count_[a] = (size_[a] + kEdge - 1) / kEdge;
    signs_.assign(std::size_t(count_[0]) * std::size_t(count_[1]) * std::size_t(count_[2]), 0);
    parallel_for(count_[2], [&](std::ptrdiff_t c) {
      for (int k = int(c) * kEdge; k < std::min((int(c) + 1) * kEdge, size_[2]); ++k)
        for (int j = 0; j < size_[1]; ++j) {
          const float* row = &level.at(0, j, k);
          std::uint8_t* cells = &signs_[offset(0, j / kEdge, int(c))];
          for (int i = 0; i < size_[0]; i += kEdge, ++cells) {
            const int end = std::min(i + kEdge, size_[0]);
            int inside = 0;
            for (int n = i; n < end; ++n) inside += int(row[n] < 0.0f);
            *cells = std::uint8_t(*cells | (inside > 0 ? 1 : 0) | (inside < end - i ? 2 : 0));
          }
        }
    });
  }
  /// Whether there are both in a brick or beside it (by up to a cell more than the border).
  [[nodiscard]] bool has_both_near(const Brick& brick, int border) const {
    std::array<int, 3> low{}, high{};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max(brick.first[a] - border, 0) / kEdge;
      high[a] = std::min(brick.first[a] + brick.size[a] + border, size_[a]) - 1;
      high[a] /= kEdge;
    }
    std::uint8_t signs = 0;
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i)
          signs = std::uint8_t(signs | signs_[offset(i, j, k)]);
    return signs == 3;
  }

 private:
  static constexpr int kEdge = 8;
  [[nodiscard]] std::size_t offset(int i, int j, int k) const {
    return (std::size_t(k) * std::size_t(count_[1]) + std::size_t(j)) * std::size_t(count_[0]) +
           std::size_t(i);
  }
  std::array<int, 3> size_;
  std::array<int, 3> count_{};
  std::vector<std::uint8_t> signs_;  ///< 1: inside, 2: outside, 3: both
};

double band_of(const VolumeGeometry& geometry) { return kBandVoxels * geometry.longest_spacing(); }

/// Turns a level into distances that end at the reach on both sides.
void end_at_band(Volume<float>& level, double reach_mm, double refined_mm) {
  const Vec3& h = level.geometry.spacing;
  const int border = 1 + int(std::ceil(reach_mm / std::min({h.x, h.y, h.z})));
  const SignCells cells(level);
  const auto bricks = bricks_with(level.geometry, kBrick, [](const Brick&) { return true; });
  std::vector<std::vector<float>> near(bricks.size());
  constexpr std::size_t kTogether = 4;  // share their memory
  parallel_for_uneven(
      std::ptrdiff_t((bricks.size() + kTogether - 1) / kTogether), [&](std::ptrdiff_t group) {
        BrickDistance work(level, reach_mm, refined_mm);
        const std::size_t first = std::size_t(group) * kTogether;
        for (std::size_t b = first; b < std::min(first + kTogether, bricks.size()); ++b)
          if (cells.has_both_near(bricks[b], border)) near[b] = work.run(bricks[b]);
      });
  const auto far = float(reach_mm);
  parallel_for_uneven(std::ptrdiff_t(bricks.size()), [&](std::ptrdiff_t b) {
    const Brick& brick = bricks[std::size_t(b)];
    const float* from = near[std::size_t(b)].empty() ? nullptr : near[std::size_t(b)].data();
    for (int k = 0; k < brick.size[2]; ++k)
      for (int j = 0; j < brick.size[1]; ++j) {
        float* out = &level.at(brick.first[0], brick.first[1] + j, brick.first[2] + k);
        if (from != nullptr) {
          std::copy_n(from, brick.size[0], out);
          from += brick.size[0];
        } else {
          for (int i = 0; i < brick.size[0]; ++i) out[i] = out[i] < 0.0f ? -far : far;
        }
      }
  });
}

}  // namespace

void keep_distance_band(Volume<float>& level, double reach_mm) {
  end_at_band(level, reach_mm, 0.4 * reach_mm);
}

Volume<float> signed_distance(Volume<float> level, double reach_mm) {
  const double band = band_of(level.geometry);
  end_at_band(level, band, band);
  continue_distance(level, band, reach_mm);
  return level;
}

}  // namespace angio::segmentation::detail

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
constexpr float kFar = std::numeric_limits<float>::infinity();
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

  /// Writes the brick's distances into the result.
  void run(const Brick& brick, Volume<float>& result) {
    gather(patch_, level_, {1, 1, 1}, brick, border_);
    if (!find_first_layer()) return;
    propagate();
    refine_near(brick);
    for (int k = 0; k < brick.size[2]; ++k)
      for (int j = 0; j < brick.size[1]; ++j) {
        float* out = &result.at(brick.first[0], brick.first[1] + j, brick.first[2] + k);
        const std::size_t from = patch_.offset(border_, j + border_, k + border_);
        for (int i = 0; i < brick.size[0]; ++i) {
          const float d = std::min(std::sqrt(squared_[from + std::size_t(i)]), reach_);
          out[i] = patch_.values[from + std::size_t(i)] < 0.0f ? -d : d;
        }
      }
  }

 private:
  [[nodiscard]] bool is_inside(std::size_t v) const { return patch_.values[v] < 0.0f; }
  [[nodiscard]] std::array<int, 3> place(std::size_t v) const {
    const auto ni = std::size_t(patch_.size[0]), nj = std::size_t(patch_.size[1]);
    return {int(v % ni), int(v / ni % nj), int(v / ni / nj)};
  }
  [[nodiscard]] Slope sample(const std::array<int, 3>& voxel, const Offset& way) const;
  [[nodiscard]] Offset refine(const std::array<int, 3>& voxel, const Offset& start) const;
  bool find_first_layer();
  void propagate();
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

/// @return false if the zero does not come near the brick
bool BrickDistance::find_first_layer() {
  squared_.assign(patch_.values.size(), kFar);
  offset_.resize(patch_.values.size());
  const auto [ni, nj, nk] = patch_.size;
  const std::array<std::ptrdiff_t, 3> stride{1, ni, std::ptrdiff_t(ni) * nj};
  bool is_any = false;
  for (int k = 1; k + 1 < nk; ++k)
    for (int j = 1; j + 1 < nj; ++j) {
      const float* row = patch_.row(j, k);
      for (int i = 1; i + 1 < ni; ++i) {
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

/// Hands closest points on from near voxels to far ones, on each side of the surface by itself.
void BrickDistance::propagate() {
  const float step = 0.25f * std::min({h_.x, h_.y, h_.z});
  front_.assign(std::size_t(reach_ / step) + 2, {});
  const auto push = [&](std::size_t v, std::size_t now) {
    const auto bucket = std::max(now, std::size_t(std::sqrt(squared_[v]) / step));
    if (bucket < front_.size()) front_[bucket].push_back(std::uint32_t(v));
  };
  for (std::size_t v = 0; v < squared_.size(); ++v)
    if (squared_[v] != kFar) push(v, 0);
  std::vector<std::uint8_t> is_done(squared_.size(), 0);
  for (std::size_t now = 0; now < front_.size(); ++now)
    for (std::size_t n = 0; n < front_[now].size(); ++n) {
      const std::size_t v = front_[now][n];
      if (std::exchange(is_done[v], std::uint8_t{1})) continue;
      const auto at = place(v);
      if (at[0] < 1 || at[1] < 1 || at[2] < 1 || at[0] + 1 >= patch_.size[0] ||
          at[1] + 1 >= patch_.size[1] || at[2] + 1 >= patch_.size[2])
        continue;
      for (int dk = -1; dk <= 1; ++dk)
        for (int dj = -1; dj <= 1; ++dj)
          for (int di = -1; di <= 1; ++di) {
            const std::size_t other = patch_.offset(at[0] + di, at[1] + dj, at[2] + dk);
            if (is_done[other] || is_inside(other) != is_inside(v)) continue;
            const Offset way =
                offset_[v] - Offset{float(di) * h_.x, float(dj) * h_.y, float(dk) * h_.z};
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

/// Whether a level has both signs, or is near its zero, in a brick or within the reach beside it.
bool has_zero_near(const Volume<float>& level, const Brick& brick, int border) {
  const auto& size = level.geometry.size;
  std::array<int, 3> low{}, high{};
  for (std::size_t a = 0; a < 3; ++a) {
    low[a] = std::max(brick.first[a] - border, 0);
    high[a] = std::min(brick.first[a] + brick.size[a] + border, size[a]);
  }
  const bool inside = level.at(low[0], low[1], low[2]) < 0.0f;
  for (int k = low[2]; k < high[2]; ++k)
    for (int j = low[1]; j < high[1]; ++j) {
      const float* row = &level.at(0, j, k);
      int other = 0;
      for (int i = low[0]; i < high[0]; ++i) other += int((row[i] < 0.0f) != inside);
      if (other > 0) return true;
    }
  return false;
}

double band_of(const VolumeGeometry& geometry) {
  return kBandVoxels * std::max({geometry.spacing.x, geometry.spacing.y, geometry.spacing.z});
}

/// Distances that end at the reach on both sides.
Volume<float> banded(const Volume<float>& level, double reach_mm, double refined_mm) {
  Volume<float> result(level.geometry);
  const std::size_t slice = result.values.size() / std::size_t(level.geometry.size[2]);
  parallel_for(level.geometry.size[2], [&](std::ptrdiff_t k) {
    for (std::size_t v = std::size_t(k) * slice; v < (std::size_t(k) + 1) * slice; ++v)
      result.values[v] = level.values[v] < 0.0f ? -float(reach_mm) : float(reach_mm);
  });
  const Vec3& h = level.geometry.spacing;
  const int border = 1 + int(std::ceil(reach_mm / std::min({h.x, h.y, h.z})));
  const auto bricks = bricks_with(level.geometry, kBrick, [&](const Brick& brick) {
    return has_zero_near(level, brick, border);
  });
  parallel_for_uneven(std::ptrdiff_t(bricks.size()), [&](std::ptrdiff_t b) {
    BrickDistance(level, reach_mm, refined_mm).run(bricks[std::size_t(b)], result);
  });
  return result;
}

}  // namespace

Volume<float> signed_distance_band(const Volume<float>& level, double reach_mm) {
  return banded(level, reach_mm, 0.4 * reach_mm);
}

Volume<float> signed_distance(const Volume<float>& level, double reach_mm) {
  const double band = band_of(level.geometry);
  Volume<float> distance = banded(level, band, band);
  continue_distance(distance, band, reach_mm);
  return distance;
}

}  // namespace angio::segmentation::detail

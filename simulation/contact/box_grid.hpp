#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "core/vec3.hpp"

/// Which boxes meet, found by a grid.
namespace angio::simulation::detail {

/// Along the axes.
struct Box {
  Vec3 low{std::numeric_limits<double>::max(), std::numeric_limits<double>::max(),
           std::numeric_limits<double>::max()};
  Vec3 high = -low;

  void add(const Vec3& p) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  void grow(double by) {
    for (int k = 0; k < 3; ++k) {
      low[k] -= by;
      high[k] += by;
    }
  }
  [[nodiscard]] bool meets(const Box& b) const {
    for (int k = 0; k < 3; ++k)
      if (low[k] > b.high[k] || high[k] < b.low[k]) return false;
    return true;
  }
  [[nodiscard]] bool holds(const Box& b) const {
    for (int k = 0; k < 3; ++k)
      if (b.low[k] < low[k] || b.high[k] > high[k]) return false;
    return true;
  }
};

/// Around some vertices, larger by `grow`.
template <class Indices>
Box box_of(const std::vector<Vec3>& x, const Indices& vertices, double grow) {
  Box box;
  for (const int v : vertices) box.add(x[std::size_t(v)]);
  box.grow(grow);
  return box;
}

/// A uniform grid over a part of space; each cell lists the boxes that meet it.
class BoxGrid {
 public:
  BoxGrid(const Box& space, double cell) : space_(space) {
    for (int k = 0; k < 3; ++k) {
      const double length = space.high[k] - space.low[k];
      size_[std::size_t(k)] = std::clamp(int(length / cell), 1, 128);
      scale_[k] = length > 0.0 ? size_[std::size_t(k)] / length : 0.0;
    }
  }

  void fill(std::vector<Box> boxes) {
    boxes_ = std::move(boxes);
    begin_.assign(std::size_t(size_[0]) * std::size_t(size_[1]) * std::size_t(size_[2]) + 1, 0);
    for (const Box& box : boxes_)
      for_cells(box, [&](std::size_t c, int, int, int) { ++begin_[c + 1]; });
    for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    items_.resize(std::size_t(begin_.back()));
    for (std::size_t b = 0; b < boxes_.size(); ++b)
      for_cells(boxes_[b],
                [&](std::size_t c, int, int, int) { items_[std::size_t(next[c]++)] = int(b); });
  }

  /// Calls body(item) once for each box that meets the given one.
  template <class Body>
  void query(const Box& box, const Body& body) const {
    if (!box.meets(space_)) return;
    for_cells(box, [&](std::size_t c, int i, int j, int k) {
      for (int n = begin_[c]; n < begin_[c + 1]; ++n) {
        const Box& other = boxes_[std::size_t(items_[std::size_t(n)])];
        if (!box.meets(other)) continue;
        // Of the cells that both meet, only the first one counts.
        if (i == std::max(cell(box.low.x, 0), cell(other.low.x, 0)) &&
            j == std::max(cell(box.low.y, 1), cell(other.low.y, 1)) &&
            k == std::max(cell(box.low.z, 2), cell(other.low.z, 2)))
          body(items_[std::size_t(n)]);
      }
    });
  }

 private:
  [[nodiscard]] int cell(double value, int axis) const {
    const double c = (value - space_.low[axis]) * scale_[axis];
    return c <= 0.0 ? 0 : std::min(int(c), size_[std::size_t(axis)] - 1);
  }
  template <class Body>
  void for_cells(const Box& box, const Body& body) const {
    for (int k = cell(box.low.z, 2); k <= cell(box.high.z, 2); ++k)
      for (int j = cell(box.low.y, 1); j <= cell(box.high.y, 1); ++j)
        for (int i = cell(box.low.x, 0); i <= cell(box.high.x, 0); ++i)
          body((std::size_t(k) * std::size_t(size_[1]) + std::size_t(j)) * std::size_t(size_[0]) +
                   std::size_t(i),
               i, j, k);
  }

  Box space_;
  std::array<int, 3> size_{};
  Vec3 scale_;
  std::vector<Box> boxes_;
  std::vector<int> begin_, items_;
};

/// Around each of the primitives, lists of vertices.
template <class Primitives>
std::vector<Box> boxes_of(const std::vector<Vec3>& x, const Primitives& primitives, double grow) {
  std::vector<Box> boxes(primitives.size());
  for (std::size_t i = 0; i < primitives.size(); ++i) boxes[i] = box_of(x, primitives[i], grow);
  return boxes;
}

}  // namespace angio::simulation::detail

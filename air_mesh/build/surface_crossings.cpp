#include "air_mesh/build/surface_crossings.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/parallel.hpp"

namespace angio::air_mesh {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;

Point to_cgal(const Vec3& p) { return {p.x, p.y, p.z}; }

Triangles to_triangles(const TriangleMesh& mesh) {
  Triangles triangles;
  triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    triangles.emplace_back(to_cgal(mesh.vertices[std::size_t(t[0])]),
                           to_cgal(mesh.vertices[std::size_t(t[1])]),
                           to_cgal(mesh.vertices[std::size_t(t[2])]));
  return triangles;
}

using Box = CGAL::Box_intersection_d::Box_with_handle_d<double, 3, Triangles::const_iterator>;

std::vector<Box> to_boxes(const Triangles& triangles) {
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (auto t = triangles.begin(); t != triangles.end(); ++t) boxes.emplace_back(t->bbox(), t);
  return boxes;
}

/// Do two triangles of one mesh meet anywhere but in the corners they share?
bool cross_beyond_shared(const Triangles& points, const Triangle& a, const Triangle& b,
                         std::size_t index_a, std::size_t index_b) {
  int shared_count = 0;
  int corner_a = 0, corner_b = 0;  // the shared corner, when it is one
  int other_a = 0, other_b = 0;    // the corner that is not shared, when two are
  for (int i = 0; i < 3; ++i) {
    bool shared = false;
    for (int j = 0; j < 3; ++j)
      if (a[std::size_t(i)] == b[std::size_t(j)]) {
        shared = true;
        ++shared_count;
        corner_a = i;
        corner_b = j;
      }
    if (!shared) other_a = i;
  }
  const Kernel::Triangle_3& ta = points[index_a];
  const Kernel::Triangle_3& tb = points[index_b];
  if (shared_count == 0) return CGAL::do_intersect(ta, tb);
  if (shared_count == 3) return true;
  if (shared_count == 1) {
    // They meet elsewhere exactly if the far edge of one meets the other triangle.
    const Kernel::Segment_3 far_a(ta[corner_a + 1], ta[corner_a + 2]);
    const Kernel::Segment_3 far_b(tb[corner_b + 1], tb[corner_b + 2]);
    return CGAL::do_intersect(ta, far_b) || CGAL::do_intersect(tb, far_a);
  }
  // Sharing an edge, they overlap only if they are folded flat onto each other.
  for (int j = 0; j < 3; ++j) {
    const int v = b[std::size_t(j)];
    if (v != a[0] && v != a[1] && v != a[2]) other_b = j;
  }
  const Point& p = ta[other_a + 1];
  const Point& q = ta[other_a + 2];
  return CGAL::coplanar(p, q, ta[other_a], tb[other_b]) &&
         CGAL::coplanar_orientation(p, q, ta[other_a], tb[other_b]) == CGAL::POSITIVE;
}

/// Only triangles that are all but flat need the exact answer.
std::vector<char> degenerate_triangles(const TriangleMesh& mesh, const Triangles& triangles) {
  constexpr double kFlat = 1e-18;  // squared sine of an angle
  std::vector<char> degenerate(triangles.size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Triangle& c = mesh.triangles[t];
    const Vec3 u = mesh.vertices[std::size_t(c[1])] - mesh.vertices[std::size_t(c[0])];
    const Vec3 v = mesh.vertices[std::size_t(c[2])] - mesh.vertices[std::size_t(c[0])];
    if (norm_squared(cross(u, v)) > kFlat * norm_squared(u) * norm_squared(v)) continue;
    degenerate[t] = triangles[t].is_degenerate() ? 1 : 0;
  }
  return degenerate;
}

/// Marked triangles in cubic cells by their boxes.
class TriangleGrid {
 public:
  TriangleGrid(const TriangleMesh& mesh, const std::vector<char>& marked)
      : boxes_(mesh.triangles.size()) {
    for (std::size_t t = 0; t < boxes_.size(); ++t) boxes_[t] = box_of(mesh, mesh.triangles[t]);
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (!marked[t]) continue;
      const Range& box = boxes_[t];
      sum += std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z});
      ++count;
      for (int axis = 0; axis < 3; ++axis) {
        all_.low[axis] = std::min(all_.low[axis], box.low[axis]);
        all_.high[axis] = std::max(all_.high[axis], box.high[axis]);
      }
    }
    cell_ = count > 0 && sum > 0.0 ? 1.5 * sum / double(count) : 1.0;
    bits_ = int(std::bit_width(2 * count + 16));
    std::vector<std::uint32_t> keys;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (marked[t]) {
        for_cells(boxes_[t], [&](std::uint32_t key) { keys.push_back(key); });
      }
    first_.assign((std::size_t(1) << bits_) + 1, 0);
    for (const std::uint32_t key : keys) ++first_[key + 1];
    for (std::size_t k = 0; k + 1 < first_.size(); ++k) first_[k + 1] += first_[k];
    triangles_.resize(keys.size());
    std::vector<int> next(first_.begin(), first_.end() - 1);
    std::size_t at = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (marked[t]) {
        for_cells(boxes_[t],
                  [&](std::uint32_t) { triangles_[std::size_t(next[keys[at++]]++)] = int(t); });
      }
  }

  /// Does a triangle's box overlap the box around all marked triangles?
  [[nodiscard]] bool may_meet(int t) const { return overlap(boxes_[std::size_t(t)], all_); }

  /// Marked triangles whose boxes overlap that of a triangle, ascending, each once.
  void near(int t, std::vector<int>& found) const {
    found.clear();
    const Range& box = boxes_[std::size_t(t)];
    for_cells(box, [&](std::uint32_t key) {
      for (int i = first_[key]; i < first_[key + 1]; ++i) {
        const int other = triangles_[std::size_t(i)];
        if (overlap(boxes_[std::size_t(other)], box)) found.push_back(other);
      }
    });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
  }

 private:
  struct Range {
    Vec3 low, high;
  };
  static Range box_of(const TriangleMesh& mesh, const Triangle& c) {
    Range box{mesh.vertices[std::size_t(c[0])], mesh.vertices[std::size_t(c[0])]};
    for (const int v : {c[1], c[2]})
      for (int axis = 0; axis < 3; ++axis) {
        const double x = mesh.vertices[std::size_t(v)][axis];
        box.low[axis] = std::min(box.low[axis], x);
        box.high[axis] = std::max(box.high[axis], x);
      }
    return box;
  }
  /// Cells that share a key are looked at in vain only.
  void for_cells(const Range& box, const auto& visit) const {
    std::int64_t low[3];
    std::int64_t high[3];
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::int64_t(std::floor(box.low[axis] / cell_));
      high[axis] = std::int64_t(std::floor(box.high[axis] / cell_));
    }
    for (std::int64_t k = low[2]; k <= high[2]; ++k)
      for (std::int64_t j = low[1]; j <= high[1]; ++j)
        for (std::int64_t i = low[0]; i <= high[0]; ++i) {
          const std::uint64_t mixed =
              (std::uint64_t(i) * 0x9E3779B97F4A7C15ULL + std::uint64_t(j)) *
                  0xBF58476D1CE4E5B9ULL +
              std::uint64_t(k);
          visit(std::uint32_t((mixed * 0x94D049BB133111EBULL) >> (64 - bits_)));
        }
  }

  static bool overlap(const Range& a, const Range& b) {
    bool overlaps = true;
    for (int axis = 0; axis < 3; ++axis)
      overlaps = overlaps && a.low[axis] <= b.high[axis] && b.low[axis] <= a.high[axis];
    return overlaps;
  }

  std::vector<Range> boxes_;                                    ///< of every triangle
  Range all_{{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};  ///< around the marked ones
  double cell_ = 1.0;
  int bits_ = 4;
  std::vector<int> first_;  ///< of each key, into triangles_
  std::vector<int> triangles_;
};

}  // namespace

std::vector<std::array<int, 2>> self_intersections(const TriangleMesh& mesh) {
  return self_intersections_of(mesh, std::vector<char>(mesh.triangles.size(), 1));
}

std::vector<std::array<int, 2>> self_intersections_of(const TriangleMesh& mesh,
                                                      const std::vector<char>& marked) {
  const TriangleGrid grid(mesh, marked);
  const Triangles triangles = to_triangles(mesh);
  const std::vector<char> degenerate = degenerate_triangles(mesh, triangles);
  constexpr std::size_t kBlock = 1024;  // triangles; a block's pairs are gathered by one thread
  std::vector<std::vector<std::array<int, 2>>> found((triangles.size() + kBlock - 1) / kBlock);
  parallel_for_uneven(std::ptrdiff_t(found.size()), [&](std::ptrdiff_t block) {
    std::vector<int> candidates;
    const std::size_t first = std::size_t(block) * kBlock;
    for (std::size_t i = first; i < std::min(first + kBlock, triangles.size()); ++i) {
      auto& pairs = found[std::size_t(block)];
      if (!grid.may_meet(int(i))) continue;
      if (degenerate[i]) {
        if (marked[i]) pairs.push_back({int(i), int(i)});
        continue;
      }
      grid.near(int(i), candidates);
      for (const int other : candidates) {
        const auto j = std::size_t(other);
        // Two marked triangles meet each other twice; one of these times counts.
        if (i == j || degenerate[j] || (marked[i] && j < i)) continue;
        if (cross_beyond_shared(triangles, mesh.triangles[i], mesh.triangles[j], i, j))
          pairs.push_back({int(std::min(i, j)), int(std::max(i, j))});
      }
    }
  });
  std::vector<std::array<int, 2>> pairs;
  for (const auto& part : found) pairs.insert(pairs.end(), part.begin(), part.end());
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<std::array<int, 2>> intersections(const TriangleMesh& mesh_a,
                                              const TriangleMesh& mesh_b) {
  const Triangles triangles_a = to_triangles(mesh_a);
  const Triangles triangles_b = to_triangles(mesh_b);
  std::vector<Box> boxes_a = to_boxes(triangles_a);
  std::vector<Box> boxes_b = to_boxes(triangles_b);
  std::vector<std::array<int, 2>> pairs;
  CGAL::box_intersection_d(boxes_a.begin(), boxes_a.end(), boxes_b.begin(), boxes_b.end(),
                           [&](const Box& a, const Box& b) {
                             if (CGAL::do_intersect(*a.handle(), *b.handle()))
                               pairs.push_back({int(a.handle() - triangles_a.begin()),
                                                int(b.handle() - triangles_b.begin())});
                           });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace angio::air_mesh

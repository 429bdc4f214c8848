#include "simulation/detail/contact_set.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"

namespace angio::simulation::detail {
namespace {

// Both sides together may use up this share of a gap before the next detection.
constexpr double kShareOfGap = 0.45;
constexpr int kChunks = 32;                   // fixed, so that the order of the pairs is
constexpr std::size_t kLeastParallel = 8192;  // fewer queries run on one thread

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
};

template <class Indices>
Box box_of(const std::vector<Vec3>& x, const Indices& vertices, double grow) {
  Box box;
  for (const int v : vertices) box.add(x[std::size_t(v)]);
  box.grow(grow);
  return box;
}

// A uniform grid over the balloon; each cell lists the primitives whose boxes meet it.
class Grid {
 public:
  Grid(const Box& space, double cell) : space_(space) {
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

  // Calls body(item) once for each box that meets the given one.
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

// Fills a pair's gap and bounds; false if the gap is wider than reach.
bool set_bounds(const std::vector<Vec3>& x, double reach, ContactPair& pair) {
  const Vec3 p[4] = {x[std::size_t(pair.vertex[0])], x[std::size_t(pair.vertex[1])],
                     x[std::size_t(pair.vertex[2])], x[std::size_t(pair.vertex[3])]};
  pair.weights = pair.edges ? segment_segment_gap(p[0], p[1], p[2], p[3])
                            : point_triangle_gap(p[0], p[1], p[2], p[3]);
  Vec3 gap, closest_a, closest_b;
  const int side_a = pair.edges ? 2 : 1;
  for (int i = 0; i < 4; ++i) {
    gap += pair.weights.w[i] * p[i];
    (i < side_a ? closest_a : closest_b) += std::abs(pair.weights.w[i]) * p[i];
  }
  const double d = norm(gap);
  if (!(d < reach)) return false;
  pair.normal = normalized(gap);
  for (int i = 0; i < 4; ++i) {
    const double beyond =
        i < side_a ? dot(pair.normal, p[i] - closest_b) : dot(pair.normal, closest_a - p[i]);
    pair.limit[i] = std::max(0.0, beyond - (1.0 - kShareOfGap) * d);
  }
  return true;
}

struct Builder {
  const Scene& scene;
  const std::vector<Vec3>& x;
  const std::vector<double>& area;
  double reach;

  // Runs query(i, pairs) over [0, count) in chunks and appends the chunks in order.
  template <class Query>
  void gather(std::size_t count, std::vector<ContactPair>& pairs, const Query& query) const {
    if (count < kLeastParallel) {
      for (std::size_t i = 0; i < count; ++i) query(i, pairs);
      return;
    }
    std::vector<std::vector<ContactPair>> found(kChunks);
    parallel_for_uneven(kChunks, [&](std::ptrdiff_t chunk) {
      const std::size_t begin = count * std::size_t(chunk) / kChunks;
      const std::size_t end = count * std::size_t(chunk + 1) / kChunks;
      for (std::size_t i = begin; i < end; ++i) query(i, found[std::size_t(chunk)]);
    });
    for (const auto& part : found) pairs.insert(pairs.end(), part.begin(), part.end());
  }

  void add(std::vector<ContactPair>& pairs, int a, int b, int c, int d, bool edges) const {
    ContactPair pair;
    pair.vertex[0] = a;
    pair.vertex[1] = b;
    pair.vertex[2] = c;
    pair.vertex[3] = d;
    pair.edges = edges;
    if (!set_bounds(x, reach, pair)) return;
    // A point stands for half its own area (the other surface's points for the other half), an
    // edge pair for what is left between: a sixth of the mean area at its ends.
    pair.area = edges ? (area[std::size_t(a)] + area[std::size_t(b)] + area[std::size_t(c)] +
                         area[std::size_t(d)]) /
                            24.0
                      : 0.5 * area[std::size_t(a)];
    pairs.push_back(pair);
  }
};

template <class Primitives>
std::vector<Box> boxes_of(const std::vector<Vec3>& x, const Primitives& primitives, double grow) {
  std::vector<Box> boxes(primitives.size());
  for (std::size_t i = 0; i < primitives.size(); ++i) boxes[i] = box_of(x, primitives[i], grow);
  return boxes;
}

void index_by_vertex(std::size_t vertex_count, ContactSet& set) {
  set.ref_begin.assign(vertex_count + 1, 0);
  for (const ContactPair& pair : set.pairs)
    for (const int v : pair.vertex) ++set.ref_begin[std::size_t(v) + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) set.ref_begin[v + 1] += set.ref_begin[v];
  std::vector<int> next(set.ref_begin.begin(), set.ref_begin.end() - 1);
  set.refs.resize(4 * set.pairs.size());
  for (std::size_t p = 0; p < set.pairs.size(); ++p)
    for (int corner = 0; corner < 4; ++corner)
      set.refs[std::size_t(next[std::size_t(set.pairs[p].vertex[corner])]++)] = {int(p), corner};
}

// The planes of a vertex's pairs that it can reach at all.
void collect_bounds(std::size_t vertex_count, ContactSet& set) {
  set.bound_begin.assign(1, 0);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    for (int r = set.ref_begin[v]; r < set.ref_begin[v + 1]; ++r) {
      const auto [index, corner] = set.refs[std::size_t(r)];
      const ContactPair& pair = set.pairs[std::size_t(index)];
      if (pair.limit[corner] >= set.travel) continue;
      const bool side_a = corner < (pair.edges ? 2 : 1);
      set.bounds.push_back({side_a ? pair.normal : -pair.normal, pair.limit[corner]});
    }
    set.bound_begin.push_back(int(set.bounds.size()));
  }
}

}  // namespace

ContactSet find_contacts(const Scene& scene, const std::vector<Vec3>& x,
                         const std::vector<double>& area, double reach, double travel) {
  ContactSet set;
  set.travel = travel;
  if (scene.wall_count == 0) {
    set.ref_begin.assign(x.size() + 1, 0);
    set.bound_begin = set.ref_begin;
    return set;
  }
  const Builder builder{scene, x, area, reach};
  Box space;
  for (int v = 0; v < scene.balloon_count; ++v) space.add(x[std::size_t(v)]);
  space.grow(reach);
  double edge = 0.0;
  for (const Edge& e : scene.balloon_edges)
    edge += distance(x[std::size_t(e[0])], x[std::size_t(e[1])]);
  Grid grid(space, std::max(edge / double(scene.balloon_edges.size()), reach));

  grid.fill(boxes_of(x, scene.balloon_triangles, reach));
  builder.gather(std::size_t(scene.wall_count), set.pairs, [&](std::size_t i, auto& pairs) {
    const int v = scene.balloon_count + int(i);
    grid.query(box_of(x, std::array{v}, 0.0), [&](int t) {
      const Triangle& b = scene.balloon_triangles[std::size_t(t)];
      builder.add(pairs, v, b[0], b[1], b[2], false);
    });
  });
  std::vector<std::array<int, 1>> points(std::size_t(scene.balloon_count));
  for (int v = 0; v < scene.balloon_count; ++v) points[std::size_t(v)] = {v};
  grid.fill(boxes_of(x, points, reach));
  builder.gather(scene.wall_triangles.size(), set.pairs, [&](std::size_t i, auto& pairs) {
    const Triangle& t = scene.wall_triangles[i];
    grid.query(box_of(x, t, 0.0), [&](int v) { builder.add(pairs, v, t[0], t[1], t[2], false); });
  });
  grid.fill(boxes_of(x, scene.balloon_edges, reach));
  builder.gather(scene.wall_edges.size(), set.pairs, [&](std::size_t i, auto& pairs) {
    const Edge& e = scene.wall_edges[i];
    grid.query(box_of(x, e, 0.0), [&](int b) {
      const Edge& other = scene.balloon_edges[std::size_t(b)];
      builder.add(pairs, other[0], other[1], e[0], e[1], true);
    });
  });
  index_by_vertex(x.size(), set);
  collect_bounds(x.size(), set);
  return set;
}

}  // namespace angio::simulation::detail

#include "simulation/contact/candidates.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "core/parallel.hpp"
#include "simulation/contact/distance.hpp"
#include "simulation/step/near_pairs.hpp"

namespace angio::simulation::detail {
namespace {

constexpr int kChunks = 32;
constexpr std::size_t kLeastParallel = 8192;  // fewer queries run on one thread

// Contact of the membrane with itself acts below this share of the gap that a pair starts with: so
// it pushes nothing in the start shape, however near its layers, and however fine the mesh. A
// smooth membrane's neighbours keep about their start gap, and never meet.
constexpr double kShareOfStartGap = 0.9;

constexpr double kFloatRounding = 1.2e-7;  // relative

constexpr double kFacing = -0.5;  // cosine of normals that are opposed

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

struct Builder {
  const std::vector<Vec3>& x;
  double radius;

  // Runs query(i, found) over [0, count) in chunks and appends the chunks in order.
  template <class Query>
  void gather(std::size_t count, std::vector<Candidate>& candidates, const Query& query) const {
    if (count < kLeastParallel) {
      for (std::size_t i = 0; i < count; ++i) query(i, candidates);
      return;
    }
    std::vector<std::vector<Candidate>> found(kChunks);
    parallel_for_uneven(kChunks, [&](std::ptrdiff_t chunk) {
      const std::size_t begin = count * std::size_t(chunk) / kChunks;
      const std::size_t end = count * std::size_t(chunk + 1) / kChunks;
      for (std::size_t i = begin; i < end; ++i) query(i, found[std::size_t(chunk)]);
    });
    std::size_t total = candidates.size();
    for (const auto& part : found) total += part.size();
    candidates.reserve(total);
    for (const auto& part : found) candidates.insert(candidates.end(), part.begin(), part.end());
  }

  void add(std::vector<Candidate>& candidates, Candidate candidate) const {
    if (is_near(x, radius, candidate)) candidates.push_back(candidate);
  }
};

// counts[i]++ by any thread. What is put in order by it must be sorted afterwards.
std::size_t take_next(std::vector<int>& counts, int i) {
  return std::size_t(
      std::atomic_ref(counts[std::size_t(i)]).fetch_add(1, std::memory_order_relaxed));
}

template <class Primitives>
std::vector<Box> boxes_of(const std::vector<Vec3>& x, const Primitives& primitives, double grow) {
  std::vector<Box> boxes(primitives.size());
  for (std::size_t i = 0; i < primitives.size(); ++i) boxes[i] = box_of(x, primitives[i], grow);
  return boxes;
}

Box balloon_space(const Scene& scene, const std::vector<Vec3>& x, double grow) {
  Box space;
  for (int v = 0; v < scene.bodies.balloon().count; ++v) space.add(x[std::size_t(v)]);
  space.grow(grow);
  return space;
}

double mean_edge(const std::vector<Edge>& edges, const std::vector<Vec3>& x) {
  double sum = 0.0;
  for (const Edge& e : edges) sum += distance(x[std::size_t(e[0])], x[std::size_t(e[1])]);
  return sum / double(edges.size());
}

// The shaft keeps the space that the folded or slender balloon has left it, so that it touches
// nothing at the start; within a contact distance of each other the two are tied.
bool take_radius(const Scene& scene, double contact_distance, Candidate& candidate) {
  const double gap = gap_of(scene.start, candidate) - contact_distance;
  candidate.shaft = true;
  candidate.radius = float(std::min(scene.rod.radius, gap));
  return gap > 0.0;
}

}  // namespace

void add_rod_candidates(const Scene& scene, const std::vector<Vec3>& x, double contact_distance,
                        double radius, std::vector<Candidate>& candidates) {
  if (scene.rod.count == 0) return;
  const int first = scene.bodies.guidewire().first;
  std::vector<Edge> segments;
  std::vector<std::array<int, 1>> nodes;
  Box space;
  for (int i = 0; i < scene.rod.count; ++i) {
    nodes.push_back({first + i});
    if (i > 0) segments.push_back({first + i - 1, first + i});
    space.add(x[std::size_t(first + i)]);
  }
  const double far = radius + scene.rod.radius;
  space.grow(far);
  const Builder builder{x, radius};
  const auto add = [&](std::vector<Candidate>& found, Candidate candidate) {
    if (take_radius(scene, contact_distance, candidate)) builder.add(found, candidate);
  };
  Grid grid(space, 2.0 * far);
  grid.fill(boxes_of(x, segments, far));
  builder.gather(std::size_t(scene.bodies.balloon().count), candidates,
                 [&](std::size_t v, auto& found) {
                   grid.query(box_of(x, std::array{int(v)}, 0.0), [&](int i) {
                     const Edge& s = segments[std::size_t(i)];
                     add(found, {{int(v), s[0], s[1], s[1]}});
                   });
                 });
  builder.gather(scene.balloon.edges.size(), candidates, [&](std::size_t e, auto& found) {
    const Edge& edge = scene.balloon.edges[e];
    grid.query(box_of(x, edge, 0.0), [&](int i) {
      const Edge& s = segments[std::size_t(i)];
      add(found, {{edge[0], edge[1], s[0], s[1]}, true});
    });
  });
  grid.fill(boxes_of(x, nodes, far));
  builder.gather(scene.balloon.triangles.size(), candidates, [&](std::size_t t, auto& found) {
    const Triangle& b = scene.balloon.triangles[t];
    grid.query(box_of(x, b, 0.0), [&](int i) { add(found, {{first + i, b[0], b[1], b[2]}}); });
  });
}

namespace {

struct Surface {
  const BodyRange& range;
  const std::vector<Triangle>& triangles;
  const std::vector<Edge>& edges;
};

void add_self_candidates(const Scene& scene, const Surface& surface, const std::vector<Vec3>& x,
                         double radius, std::vector<Candidate>& candidates) {
  const Builder builder{x, radius};
  const auto add = [&](std::vector<Candidate>& found, Candidate candidate) {
    const auto& v = candidate.vertex;
    if (std::all_of(v, v + 4, [&](int i) { return scene.fixed[std::size_t(i)] != 0; })) return;
    if (!is_near(x, radius, candidate)) return;
    candidate.self = true;
    candidate.distance =
        float(std::min(scene.self_distance, kShareOfStartGap * gap_of(scene.start, candidate)));
    found.push_back(candidate);
  };
  Box space;
  for (int v = surface.range.first; v < surface.range.end(); ++v) space.add(x[std::size_t(v)]);
  space.grow(radius);
  Grid grid(space, std::max(mean_edge(surface.edges, x), radius));
  grid.fill(boxes_of(x, surface.triangles, radius));
  builder.gather(std::size_t(surface.range.count), candidates, [&](std::size_t i, auto& found) {
    const int v = surface.range.first + int(i);
    grid.query(box_of(x, std::array{v}, 0.0), [&](int k) {
      const Triangle& t = surface.triangles[std::size_t(k)];
      if (std::find(t.begin(), t.end(), v) == t.end()) add(found, {{v, t[0], t[1], t[2]}});
    });
  });
  grid.fill(boxes_of(x, surface.edges, radius));
  builder.gather(surface.edges.size(), candidates, [&](std::size_t e, auto& found) {
    const Edge& a = surface.edges[e];
    grid.query(box_of(x, a, 0.0), [&](int i) {
      const Edge& b = surface.edges[std::size_t(i)];
      const bool apart = a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1];
      if (std::size_t(i) > e && apart) add(found, {{a[0], a[1], b[0], b[1]}, true});
    });
  });
}

}  // namespace

void add_balloon_self_candidates(const Scene& scene, const std::vector<Vec3>& x, double radius,
                                 std::vector<Candidate>& candidates) {
  add_self_candidates(scene, {scene.bodies.balloon(), scene.balloon.triangles, scene.balloon.edges},
                      x, radius, candidates);
}

void add_wall_self_candidates(const Scene& scene, const std::vector<Vec3>& x, double radius,
                              std::vector<Candidate>& candidates) {
  if (scene.bodies.wall().count == 0) return;
  add_self_candidates(scene, {scene.bodies.wall(), scene.wall.triangles, scene.wall.edges}, x,
                      radius, candidates);
}

bool has_facing_layers(const TriangleMesh& membrane, double within) {
  const std::vector<Vec3>& x = membrane.vertices;
  const std::vector<Vec3> normals = vertex_normals(membrane);
  Box space;
  for (const Vec3& p : x) space.add(p);
  space.grow(within);
  Grid grid(space, within);
  grid.fill(boxes_of(x, membrane.triangles, within));
  const auto faces = [&](std::size_t v, const Triangle& t) {
    const auto at = [&](std::size_t k) { return x[std::size_t(t[k])]; };
    const Vec3 normal = normalized(cross(at(1) - at(0), at(2) - at(0)));
    return dot(normal, normals[v]) < kFacing && gap_of(x, {{int(v), t[0], t[1], t[2]}}) < within;
  };
  for (std::size_t v = 0; v < x.size(); ++v) {
    bool found = false;
    grid.query(box_of(x, std::array{int(v)}, 0.0), [&](int i) {
      const Triangle& t = membrane.triangles[std::size_t(i)];
      if (std::find(t.begin(), t.end(), int(v)) == t.end()) found = found || faces(v, t);
    });
    if (found) return true;
  }
  return false;
}

std::vector<Candidate> find_candidates(const Scene& scene, const std::vector<Vec3>& x,
                                       double radius) {
  std::vector<Candidate> candidates;
  if (scene.bodies.wall().count == 0) return candidates;
  const Builder builder{x, radius};
  Grid grid(balloon_space(scene, x, radius), std::max(mean_edge(scene.balloon.edges, x), radius));

  grid.fill(boxes_of(x, scene.balloon.triangles, radius));
  builder.gather(std::size_t(scene.bodies.wall().count), candidates,
                 [&](std::size_t i, auto& found) {
                   const int v = scene.bodies.wall().first + int(i);
                   grid.query(box_of(x, std::array{v}, 0.0), [&](int t) {
                     const Triangle& b = scene.balloon.triangles[std::size_t(t)];
                     builder.add(found, {{v, b[0], b[1], b[2]}, false});
                   });
                 });
  std::vector<std::array<int, 1>> points(std::size_t(scene.bodies.balloon().count));
  for (int v = 0; v < scene.bodies.balloon().count; ++v) points[std::size_t(v)] = {v};
  grid.fill(boxes_of(x, points, radius));
  builder.gather(scene.wall.triangles.size(), candidates, [&](std::size_t i, auto& found) {
    const Triangle& t = scene.wall.triangles[i];
    grid.query(box_of(x, t, 0.0), [&](int v) {
      builder.add(found, {{v, t[0], t[1], t[2]}, false});
    });
  });
  grid.fill(boxes_of(x, scene.balloon.edges, radius));
  builder.gather(scene.wall.edges.size(), candidates, [&](std::size_t i, auto& found) {
    const Edge& e = scene.wall.edges[i];
    grid.query(box_of(x, e, 0.0), [&](int b) {
      const Edge& other = scene.balloon.edges[std::size_t(b)];
      builder.add(found, {{other[0], other[1], e[0], e[1]}, true});
    });
  });
  return candidates;
}

double gap_of(const std::vector<Vec3>& x, const Candidate& c) {
  const Vec3 p[4] = {x[std::size_t(c.vertex[0])], x[std::size_t(c.vertex[1])],
                     x[std::size_t(c.vertex[2])], x[std::size_t(c.vertex[3])]};
  const GapWeights<double> weights = closest_points(c, p);
  Vec3 gap;
  for (int i = 0; i < 4; ++i) gap += weights.w[i] * p[i];
  return norm(gap) - double(c.radius);
}

bool is_near(const std::vector<Vec3>& x, double radius, Candidate& candidate) {
  const double gap = gap_of(x, candidate);
  if (!(gap < radius)) return false;
  candidate.gap = float(gap - kFloatRounding * std::abs(gap));  // not rounded up
  return true;
}

namespace {

// The candidates that each vertex is in.
void list_candidates(std::size_t vertex_count, CandidateSet& set) {
  const std::size_t count = set.candidates.size();
  set.ref_begin.assign(vertex_count + 1, 0);
  set.refs.resize(4 * count);
  const auto for_candidates = [&](const auto& body) {
    parallel_for(std::ptrdiff_t(count), [&](std::ptrdiff_t c) { body(std::size_t(c)); });
  };
  for_candidates([&](std::size_t c) {
    for (const int v : set.candidates[c].vertex) take_next(set.ref_begin, v + 1);
  });
  std::partial_sum(set.ref_begin.begin(), set.ref_begin.end(), set.ref_begin.begin());
  std::vector<int> next = set.ref_begin;
  for_candidates([&](std::size_t c) {
    for (int corner = 0; corner < 4; ++corner)
      set.refs[take_next(next, set.candidates[c].vertex[corner])] = {int(c), corner};
  });
  const auto key = [&](const ContactRef& ref) {
    return std::tuple(set.candidates[std::size_t(ref.pair)].gap, ref.pair, ref.corner);
  };
  parallel_for_uneven(std::ptrdiff_t(vertex_count), [&](std::ptrdiff_t v) {
    std::sort(set.refs.begin() + set.ref_begin[std::size_t(v)],
              set.refs.begin() + set.ref_begin[std::size_t(v) + 1],
              [&](const ContactRef& a, const ContactRef& b) { return key(a) < key(b); });
  });
}

}  // namespace

CandidateSet index_candidates(std::size_t vertex_count, const std::vector<Candidate>& candidates,
                              double radius, bool lists) {
  CandidateSet set;
  set.search_radius = radius;
  set.owned_begin.assign(vertex_count + 1, 0);
  for (const Candidate& c : candidates) ++set.owned_begin[std::size_t(c.vertex[0]) + 1];
  std::partial_sum(set.owned_begin.begin(), set.owned_begin.end(), set.owned_begin.begin());
  std::vector<int> next = set.owned_begin;
  set.candidates.resize(candidates.size());
  for (const Candidate& c : candidates)
    set.candidates[std::size_t(next[std::size_t(c.vertex[0])]++)] = c;
  const auto key = [](const Candidate& c) {
    return std::tuple(c.gap, c.edges, c.vertex[1], c.vertex[2], c.vertex[3]);
  };
  const auto begin = set.candidates.begin();
  const auto first_owner = [&](std::ptrdiff_t chunk) {  // of about as many candidates each
    const auto share = int(std::ptrdiff_t(candidates.size()) * chunk / kChunks);
    return std::lower_bound(set.owned_begin.begin(), set.owned_begin.end() - 1, share);
  };
  parallel_for_uneven(kChunks, [&](std::ptrdiff_t chunk) {
    for (auto owner = first_owner(chunk); owner != first_owner(chunk + 1); ++owner)
      std::sort(begin + owner[0], begin + owner[1],
                [&](const Candidate& a, const Candidate& b) { return key(a) < key(b); });
  });
  if (lists) list_candidates(vertex_count, set);
  return set;
}

}  // namespace angio::simulation::detail

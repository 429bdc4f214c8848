#include "simulation/detail/air_candidates.hpp"

#include <algorithm>
#include <array>

#include "core/parallel.hpp"

namespace angio::simulation::detail {
namespace {

constexpr int kChunks = 16;
constexpr std::size_t kPatch = 16;  // triangles of the balloon that are walked around together

struct Box {
  Vec3 low, high;

  void add(const Box& b) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], b.low[k]);
      high[k] = std::max(high[k], b.high[k]);
    }
  }
  [[nodiscard]] Box grown(double by) const {
    return {low - Vec3{by, by, by}, high + Vec3{by, by, by}};
  }
  [[nodiscard]] bool meets(const Box& b) const {
    // Without branches: about half of the answers are no.
    return (int(low.x <= b.high.x) & int(low.y <= b.high.y) & int(low.z <= b.high.z) &
            int(high.x >= b.low.x) & int(high.y >= b.low.y) & int(high.z >= b.low.z)) != 0;
  }
};

template <class Indices>
Box box_of(const std::vector<Vec3>& x, const Indices& vertices, double grow) {
  Box box{x[std::size_t(vertices[0])], x[std::size_t(vertices[0])]};
  for (const int v : vertices)
    for (int k = 0; k < 3; ++k) {
      box.low[k] = std::min(box.low[k], x[std::size_t(v)][k]);
      box.high[k] = std::max(box.high[k], x[std::size_t(v)][k]);
    }
  for (int k = 0; k < 3; ++k) {
    box.low[k] -= grow;
    box.high[k] += grow;
  }
  return box;
}

template <class Primitives>
std::vector<Box> boxes_of(const std::vector<Vec3>& x, const Primitives& primitives) {
  std::vector<Box> boxes;
  boxes.reserve(primitives.size());
  for (const auto& p : primitives) boxes.push_back(box_of(x, p, 0.0));
  return boxes;
}

// Lists of primitives by vertex: `items` of vertex v from begin[v] to begin[v + 1].
struct ByVertex {
  std::vector<int> begin, items;

  // Each primitive is listed at its first vertex.
  template <class Primitives>
  ByVertex(const Primitives& primitives, std::size_t vertex_count) : begin(vertex_count + 1, 0) {
    for (const auto& p : primitives) ++begin[std::size_t(p[0]) + 1];
    for (std::size_t v = 0; v < vertex_count; ++v) begin[v + 1] += begin[v];
    std::vector<int> next(begin.begin(), begin.end() - 1);
    items.resize(primitives.size());
    for (std::size_t i = 0; i < primitives.size(); ++i)
      items[std::size_t(next[std::size_t(primitives[i][0])]++)] = int(i);
  }
  template <class Body>
  void for_items(int v, const Body& body) const {
    for (int i = begin[std::size_t(v)]; i < begin[std::size_t(v) + 1]; ++i)
      body(items[std::size_t(i)]);
  }
};

// Which tet lies at each triangle of the balloon.
std::vector<int> tets_at(const TetTopology& air, const std::vector<Triangle>& triangles) {
  struct Entry {
    Triangle key;
    int index;
    bool operator<(const Entry& other) const { return key < other.key; }
  };
  std::vector<Entry> entries;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Triangle key = triangles[t];
    std::sort(key.begin(), key.end());
    entries.push_back({key, int(t)});
  }
  std::sort(entries.begin(), entries.end());
  std::vector<int> result(triangles.size(), -1);
  for (const TetFace& f : air.boundary()) {
    Triangle key = air.face(f.tet, f.corner);
    std::sort(key.begin(), key.end());
    const auto found = std::lower_bound(entries.begin(), entries.end(), Entry{key, 0});
    if (found != entries.end() && found->key == key) result[std::size_t(found->index)] = f.tet;
  }
  return result;
}

// A walk through the air around one patch of triangles after another.
class Walk {
 public:
  Walk(const AdaptiveAir& air, const std::vector<Box>& tet_box, int balloon_count, int vertex_count)
      : air_(air.topology()),
        tet_box_(tet_box),
        balloon_count_(balloon_count),
        vertex_count_(vertex_count),
        tet_mark_(std::size_t(air_.slot_count()), -1),
        vertex_mark_(air.positions().size(), -1) {}

  // The wall's vertices of all tets that are met within `box` from the tets `start`.
  void go(const int* start, int start_count, const Box& box, int turn) {
    tets_.clear();
    met_.clear();
    turn_ = turn;
    for (int i = 0; i < start_count; ++i) reach(start[i]);
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      const int t = tets_[i];
      for (const int v : air_.tet(t)) meet(v);
      for (int c = 0; c < 4; ++c) {
        const int next = air_.across(t, c).tet;
        if (next < 0 || tet_mark_[std::size_t(next)] == turn) continue;
        if (box.meets(tet_box_[std::size_t(next)])) reach(next);
      }
    }
  }
  [[nodiscard]] bool has_met(int v) const { return vertex_mark_[std::size_t(v)] == turn_; }
  [[nodiscard]] const std::vector<int>& met() const { return met_; }

 private:
  void reach(int t) {
    if (tet_mark_[std::size_t(t)] == turn_) return;
    tet_mark_[std::size_t(t)] = turn_;
    tets_.push_back(t);
  }
  void meet(int v) {
    if (v < balloon_count_ || v >= vertex_count_ || vertex_mark_[std::size_t(v)] == turn_) return;
    vertex_mark_[std::size_t(v)] = turn_;
    met_.push_back(v);
  }

  const TetTopology& air_;
  const std::vector<Box>& tet_box_;
  int balloon_count_, vertex_count_, turn_ = -1;
  std::vector<int> tet_mark_, vertex_mark_, tets_, met_;
};

// The triangle that a primitive of the balloon is looked after by.
struct Owners {
  std::vector<std::vector<int>> vertices, edges;  ///< by triangle

  explicit Owners(const Scene& scene) {
    vertices.resize(scene.balloon_triangles.size());
    edges.resize(scene.balloon_triangles.size());
    std::vector<char> taken(std::size_t(scene.balloon_count), 0);
    std::vector<std::vector<int>> around(std::size_t(scene.balloon_count));
    for (std::size_t t = 0; t < scene.balloon_triangles.size(); ++t)
      for (const int v : scene.balloon_triangles[t]) {
        around[std::size_t(v)].push_back(int(t));
        if (taken[std::size_t(v)] != 0) continue;
        taken[std::size_t(v)] = 1;
        vertices[t].push_back(v);
      }
    for (std::size_t e = 0; e < scene.balloon_edges.size(); ++e)
      for (const int t : around[std::size_t(scene.balloon_edges[e][0])]) {
        const Triangle& f = scene.balloon_triangles[std::size_t(t)];
        if (std::find(f.begin(), f.end(), scene.balloon_edges[e][1]) == f.end()) continue;
        edges[std::size_t(t)].push_back(int(e));
        break;
      }
  }
};

// Primitives of the wall and their boxes.
class Met {
 public:
  struct Item {
    Box box;
    int index;
  };
  void clear() { items_.clear(); }
  void take(const Box& within, const Box& box, int index) {
    if (within.meets(box)) items_.push_back({box, index});
  }
  template <class Body>
  void for_near(const Box& box, const Body& body) const {
    for (const Item& item : items_)
      if (box.meets(item.box)) body(item);
  }

 private:
  std::vector<Item> items_;
};

// The pairs of a patch's triangles with what the walk around it has met.
struct PatchSearch {
  const Scene& scene;
  const std::vector<Vec3>& x;
  double reach;
  const Owners& owners;
  std::vector<Candidate>& found;
  Met points, faces, sides;

  void clear() {
    points.clear();
    faces.clear();
    sides.clear();
  }
  void add_pairs_of(std::size_t t) {
    const Triangle& b = scene.balloon_triangles[t];
    const Box box = box_of(x, b, reach);
    points.for_near(box, [&](const Met::Item& v) { add({{v.index, b[0], b[1], b[2]}, false}); });
    for (const int p : owners.vertices[t])
      faces.for_near(box_of(x, std::array{p}, reach), [&](const Met::Item& face) {
        const Triangle& w = scene.wall_triangles[std::size_t(face.index)];
        add({{p, w[0], w[1], w[2]}, false});
      });
    for (const int e : owners.edges[t]) {
      const Edge& edge = scene.balloon_edges[std::size_t(e)];
      sides.for_near(box_of(x, edge, reach), [&](const Met::Item& side) {
        const Edge& w = scene.wall_edges[std::size_t(side.index)];
        add({{edge[0], edge[1], w[0], w[1]}, true});
      });
    }
  }

 private:
  void add(Candidate candidate) {
    if (is_near(x, reach, candidate)) found.push_back(candidate);
  }
};

}  // namespace

std::vector<Candidate> find_candidates_in_air(const AdaptiveAir& air, const Scene& scene,
                                              const std::vector<Vec3>& x, double reach) {
  const Owners owners(scene);
  const std::vector<int> start = tets_at(air.topology(), scene.balloon_triangles);
  const int vertex_count = scene.balloon_count + scene.wall_count;
  const ByVertex triangles(scene.wall_triangles, std::size_t(vertex_count));
  const ByVertex edges(scene.wall_edges, std::size_t(vertex_count));

  double moved = 0.0;  // since the air followed the surfaces
  for (std::size_t v = 0; v < std::size_t(vertex_count); ++v)
    moved = std::max(moved, distance(x[v], air.positions()[v]));

  const TetTopology& topology = air.topology();
  std::vector<Box> tet_box(std::size_t(topology.slot_count()));
  for (int t = 0; t < topology.slot_count(); ++t)
    if (topology.alive(t)) tet_box[std::size_t(t)] = box_of(air.positions(), topology.tet(t), 0.0);
  const std::vector<Box> triangle_box = boxes_of(x, scene.wall_triangles);
  const std::vector<Box> edge_box = boxes_of(x, scene.wall_edges);

  const std::size_t count = scene.balloon_triangles.size();
  const auto patches = std::ptrdiff_t((count + kPatch - 1) / kPatch);
  std::vector<std::vector<Candidate>> found(kChunks);
  parallel_for_uneven(kChunks, [&](std::ptrdiff_t chunk) {
    Walk walk(air, tet_box, scene.balloon_count, vertex_count);
    PatchSearch search{scene, x, reach, owners, found[std::size_t(chunk)], {}, {}, {}};
    for (std::ptrdiff_t p = patches * chunk / kChunks; p < patches * (chunk + 1) / kChunks; ++p) {
      const std::size_t first = std::size_t(p) * kPatch, last = std::min(first + kPatch, count);
      Box box = box_of(x, scene.balloon_triangles[first], reach);
      for (std::size_t t = first + 1; t < last; ++t)
        box.add(box_of(x, scene.balloon_triangles[t], reach));
      walk.go(&start[first], int(last - first), box.grown(moved), int(p));
      search.clear();
      for (const int v : walk.met()) {
        search.points.take(box, box_of(x, std::array{v}, 0.0), v);
        triangles.for_items(v, [&](int i) {
          const Triangle& w = scene.wall_triangles[std::size_t(i)];
          if (walk.has_met(w[1]) && walk.has_met(w[2]))
            search.faces.take(box, triangle_box[std::size_t(i)], i);
        });
        edges.for_items(v, [&](int i) {
          if (walk.has_met(scene.wall_edges[std::size_t(i)][1]))
            search.sides.take(box, edge_box[std::size_t(i)], i);
        });
      }
      for (std::size_t t = first; t < last; ++t) search.add_pairs_of(t);
    }
  });
  std::vector<Candidate> candidates;
  for (const auto& part : found) candidates.insert(candidates.end(), part.begin(), part.end());
  return candidates;
}

}  // namespace angio::simulation::detail

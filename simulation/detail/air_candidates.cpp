#include "simulation/detail/air_candidates.hpp"

#include <algorithm>
#include <array>

#include "core/parallel.hpp"

namespace angio::simulation::detail {
namespace {

constexpr int kChunks = 16;

struct Box {
  Vec3 low, high;

  [[nodiscard]] bool meets(const Box& b) const {
    for (int k = 0; k < 3; ++k)
      if (low[k] > b.high[k] || high[k] < b.low[k]) return false;
    return true;
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
};

// Which tet lies at each triangle of the balloon.
std::vector<int> tets_at(const AirTopology& air, const std::vector<Triangle>& triangles) {
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
  for (const AirFace& f : air.boundary()) {
    Triangle key = air.face(f.tet, f.corner);
    std::sort(key.begin(), key.end());
    const auto found = std::lower_bound(entries.begin(), entries.end(), Entry{key, 0});
    if (found != entries.end() && found->key == key) result[std::size_t(found->index)] = f.tet;
  }
  return result;
}

// A walk through the air around one triangle after another.
class Walk {
 public:
  Walk(const AdaptiveAir& air, const std::vector<Box>& tet_box, int balloon_count, int vertex_count)
      : air_(air.topology()),
        tet_box_(tet_box),
        balloon_count_(balloon_count),
        vertex_count_(vertex_count),
        tet_mark_(std::size_t(air_.slot_count()), -1),
        vertex_mark_(air.positions().size(), -1) {}

  // The wall's vertices of all tets that are met within `box` from tet `start`.
  void go(int start, const Box& box, int turn) {
    tets_.assign(1, start);
    met_.clear();
    turn_ = turn;
    tet_mark_[std::size_t(start)] = turn;
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      const int t = tets_[i];
      for (const int v : air_.tet(t)) meet(v);
      for (int c = 0; c < 4; ++c) {
        const int next = air_.across(t, c).tet;
        if (next < 0 || tet_mark_[std::size_t(next)] == turn) continue;
        if (!box.meets(tet_box_[std::size_t(next)])) continue;
        tet_mark_[std::size_t(next)] = turn;
        tets_.push_back(next);
      }
    }
  }
  [[nodiscard]] bool has_met(int v) const { return vertex_mark_[std::size_t(v)] == turn_; }
  [[nodiscard]] const std::vector<int>& met() const { return met_; }

 private:
  void meet(int v) {
    if (v < balloon_count_ || v >= vertex_count_ || vertex_mark_[std::size_t(v)] == turn_) return;
    vertex_mark_[std::size_t(v)] = turn_;
    met_.push_back(v);
  }

  const AirTopology& air_;
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

  const AirTopology& topology = air.topology();
  std::vector<Box> tet_box(std::size_t(topology.slot_count()));
  for (int t = 0; t < topology.slot_count(); ++t)
    if (topology.alive(t)) tet_box[std::size_t(t)] = box_of(air.positions(), topology.tet(t), 0.0);
  const std::vector<Box> triangle_box = boxes_of(x, scene.wall_triangles);
  const std::vector<Box> edge_box = boxes_of(x, scene.wall_edges);

  const auto search = [&](Walk& walk, std::size_t t, std::vector<Candidate>& found) {
    const Triangle& b = scene.balloon_triangles[t];
    const auto add = [&](Candidate candidate) {
      if (is_near(x, reach, candidate)) found.push_back(candidate);
    };
    const Box box = box_of(x, b, reach);
    walk.go(start[t], box_of(x, b, reach + moved), int(t));
    for (const int v : walk.met()) {
      if (box.meets(box_of(x, std::array{v}, 0.0))) add({{v, b[0], b[1], b[2]}, false});
      for (int i = triangles.begin[std::size_t(v)]; i < triangles.begin[std::size_t(v) + 1]; ++i) {
        const auto index = std::size_t(triangles.items[std::size_t(i)]);
        const Triangle& w = scene.wall_triangles[index];
        if (!walk.has_met(w[1]) || !walk.has_met(w[2]) || !box.meets(triangle_box[index])) continue;
        for (const int p : owners.vertices[t])
          if (triangle_box[index].meets(box_of(x, std::array{p}, reach)))
            add({{p, w[0], w[1], w[2]}, false});
      }
      for (int i = edges.begin[std::size_t(v)]; i < edges.begin[std::size_t(v) + 1]; ++i) {
        const auto index = std::size_t(edges.items[std::size_t(i)]);
        const Edge& w = scene.wall_edges[index];
        if (!walk.has_met(w[1]) || !box.meets(edge_box[index])) continue;
        for (const int e : owners.edges[t]) {
          const Edge& other = scene.balloon_edges[std::size_t(e)];
          if (edge_box[index].meets(box_of(x, other, reach)))
            add({{other[0], other[1], w[0], w[1]}, true});
        }
      }
    }
  };
  std::vector<std::vector<Candidate>> found(kChunks);
  const std::size_t count = scene.balloon_triangles.size();
  parallel_for_uneven(kChunks, [&](std::ptrdiff_t chunk) {
    Walk walk(air, tet_box, scene.balloon_count, vertex_count);
    for (std::size_t t = count * std::size_t(chunk) / kChunks;
         t < count * std::size_t(chunk + 1) / kChunks; ++t)
      search(walk, t, found[std::size_t(chunk)]);
  });
  std::vector<Candidate> candidates;
  for (const auto& part : found) candidates.insert(candidates.end(), part.begin(), part.end());
  return candidates;
}

}  // namespace angio::simulation::detail

#include "simulation/contact/candidates.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.hpp"
#include "simulation/contact/box_grid.hpp"
#include "simulation/contact/candidate_gap.hpp"

namespace angio::simulation::detail {
namespace {

constexpr int kChunks = 32;
constexpr std::size_t kLeastParallel = 1024;  // fewer queries run on one thread

constexpr double kFacing = -0.5;  // cosine of normals that are opposed

// A type of this file: what is compiled for it here is nobody else's.
struct Points {
  const std::vector<Vec3>& x;
  const Vec3& operator[](std::size_t v) const { return x[v]; }
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
    if (take_radius(Points{scene.start}, scene.rod.radius, contact_distance, candidate))
      builder.add(found, candidate);
  };
  BoxGrid grid(space, 2.0 * far);
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
    take_self_distance(Points{scene.start}, scene.self_distance, candidate);
    found.push_back(candidate);
  };
  Box space;
  for (int v = surface.range.first; v < surface.range.end(); ++v) space.add(x[std::size_t(v)]);
  space.grow(radius);
  BoxGrid grid(space, std::max(mean_edge(surface.edges, x), radius));
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
  BoxGrid grid(space, within);
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
  BoxGrid grid(balloon_space(scene, x, radius),
               std::max(mean_edge(scene.balloon.edges, x), radius));

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

double gap_of(const std::vector<Vec3>& x, const Candidate& candidate) {
  return gap_at(Points{x}, candidate);
}

bool is_near(const std::vector<Vec3>& x, double radius, Candidate& candidate) {
  return take_gap(Points{x}, radius, candidate);
}

}  // namespace angio::simulation::detail

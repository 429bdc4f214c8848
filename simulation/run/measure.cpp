#include "simulation/run/measure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/parallel.hpp"

namespace angio::simulation::detail {
namespace {

using Corners = std::array<Vec3, 3>;

Corners corners_of(const std::vector<Vec3>& x, const Triangle& t) {
  return {x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])]};
}

// Does the segment (p, q) cross the triangle?
bool segment_crosses(const Vec3& p, const Vec3& q, const Corners& t) {
  const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
  const double a = dot(n, p - t[0]), b = dot(n, q - t[0]);
  if ((a > 0.0) == (b > 0.0) || a == b) return false;
  const Vec3 d = q - p;
  double sign = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double side = dot(d, cross(t[k] - p, t[(k + 1) % 3] - p));
    if (side == 0.0) continue;
    if (sign != 0.0 && (side > 0.0) != (sign > 0.0)) return false;
    sign = side;
  }
  return true;
}

bool triangles_cross(const Corners& a, const Corners& b) {
  for (std::size_t k = 0; k < 3; ++k)
    if (segment_crosses(a[k], a[(k + 1) % 3], b) || segment_crosses(b[k], b[(k + 1) % 3], a))
      return true;
  return false;
}

// The least shift along the plane normal of `b` that takes `a` to one side of it.
double depth_along(const Corners& a, const Corners& b) {
  const Vec3 n = normalized(cross(b[1] - b[0], b[2] - b[0]));
  double above = 0.0, below = 0.0;
  for (const Vec3& p : a) {
    above = std::max(above, dot(n, p - b[0]));
    below = std::max(below, -dot(n, p - b[0]));
  }
  return std::min(above, below);
}

struct Extent {
  Vec3 low, high;
};

Extent extent_of(const Corners& c) {
  Extent e{c[0], c[0]};
  for (const Vec3& p : c)
    for (int k = 0; k < 3; ++k) {
      e.low[k] = std::min(e.low[k], p[k]);
      e.high[k] = std::max(e.high[k], p[k]);
    }
  return e;
}

bool meet(const Extent& a, const Extent& b) {
  for (int k = 0; k < 3; ++k)
    if (a.low[k] > b.high[k] || a.high[k] < b.low[k]) return false;
  return true;
}

// The boxes of a surface's triangles, in ascending order along the longest side of all of them.
class SortedExtents {
 public:
  SortedExtents(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x)
      : all_{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}}, order_(triangles.size()) {
    std::vector<Extent> extents;
    for (const Triangle& t : triangles) {
      extents.push_back(extent_of(corners_of(x, t)));
      for (int k = 0; k < 3; ++k) {
        all_.low[k] = std::min(all_.low[k], extents.back().low[k]);
        all_.high[k] = std::max(all_.high[k], extents.back().high[k]);
      }
    }
    const Vec3 size = all_.high - all_.low;
    for (int k = 1; k < 3; ++k)
      if (size[k] > size[axis_]) axis_ = k;
    std::iota(order_.begin(), order_.end(), std::size_t(0));
    std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(extents[a].low[axis_], a) < std::pair(extents[b].low[axis_], b);
    });
    for (const std::size_t t : order_) {
      extents_.push_back(extents[t]);
      longest_ = std::max(longest_, extents[t].high[axis_] - extents[t].low[axis_]);
    }
  }

  // Calls body(triangle) for those whose boxes meet the given one.
  template <class Body>
  void for_meeting(const Extent& box, const Body& body) const {
    if (!meet(box, all_)) return;
    const double first = box.low[axis_] - longest_;
    auto at = std::lower_bound(extents_.begin(), extents_.end(), first,
                               [&](const Extent& e, double low) { return e.low[axis_] < low; });
    for (; at != extents_.end() && at->low[axis_] <= box.high[axis_]; ++at)
      if (meet(box, *at)) body(order_[std::size_t(at - extents_.begin())]);
  }

 private:
  static constexpr double kFar = std::numeric_limits<double>::max();
  Extent all_;
  int axis_ = 0;
  double longest_ = 0.0;
  std::vector<std::size_t> order_;
  std::vector<Extent> extents_;  // in that order
};

}  // namespace

double max_penetration(const Scene& scene, const std::vector<Vec3>& x) {
  const SortedExtents balloon(scene.balloon.triangles, x);
  std::vector<double> depth(scene.wall.triangles.size(), 0.0);
  parallel_for(std::ptrdiff_t(depth.size()), [&](std::ptrdiff_t i) {
    const Corners wall = corners_of(x, scene.wall.triangles[std::size_t(i)]);
    balloon.for_meeting(extent_of(wall), [&](std::size_t b) {
      const Corners corners = corners_of(x, scene.balloon.triangles[b]);
      if (!triangles_cross(wall, corners)) return;
      depth[std::size_t(i)] = std::max(
          depth[std::size_t(i)], std::min(depth_along(wall, corners), depth_along(corners, wall)));
    });
  });
  return depth.empty() ? 0.0 : *std::max_element(depth.begin(), depth.end());
}

int self_crossing_count(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x) {
  const SortedExtents extents(triangles, x);
  std::vector<int> count(triangles.size(), 0);
  parallel_for_uneven(std::ptrdiff_t(triangles.size()), [&](std::ptrdiff_t i) {
    const Triangle& s = triangles[std::size_t(i)];
    const Corners corners = corners_of(x, s);
    extents.for_meeting(extent_of(corners), [&](std::size_t other) {
      const Triangle& t = triangles[other];
      if (std::ptrdiff_t(other) <= i ||
          std::find_first_of(s.begin(), s.end(), t.begin(), t.end()) != s.end())
        return;
      if (triangles_cross(corners, corners_of(x, t))) ++count[std::size_t(i)];
    });
  });
  return std::accumulate(count.begin(), count.end(), 0);
}

double contact_area(const Scene& scene, const State& state) {
  double area = 0.0;
  for (const Triangle& t : scene.wall.triangles) {
    int pressed = 0;
    for (const int v : t)
      pressed += state.contact_pressure[std::size_t(v - scene.bodies.wall().first)] > 0.0 ? 1 : 0;
    if (pressed == 0) continue;
    const Corners c = corners_of(state.x, t);
    area += pressed * norm(cross(c[1] - c[0], c[2] - c[0])) / 6.0;
  }
  return area;
}

MembraneState membrane_state(const Scene& scene, const std::vector<Vec3>& x) {
  const auto count = std::size_t(scene.bodies.balloon().count);
  MembraneState state{std::vector<double>(count), std::vector<double>(count),
                      std::vector<double>(count)};
  for (std::size_t v = 0; v < count; ++v) {
    double weight = 0.0, thickness = 0.0, first = 0.0, second = 0.0;
    for (int c = scene.balloon.corner_begin[v]; c < scene.balloon.corner_begin[v + 1]; ++c) {
      const Corner& corner = scene.balloon.corners[std::size_t(c)];
      const Vec3& base = x[std::size_t(corner.next)];
      const Invariants<double> k =
          invariants(corner.rest, x[v] - base, x[std::size_t(corner.last)] - base);
      const double d = std::sqrt(std::max(0.0, k.i1 * k.i1 - 4.0 * k.i3));
      const double large = std::sqrt(0.5 * (k.i1 + d)), small = std::sqrt(k.i3) / large;
      const double w = corner.rest.volume;
      weight += w;
      first += w * large;
      second += w * small;
      // A wrinkled or folded membrane is as thick as its own tension makes it, not as its cover:
      // uniaxial tension leaves l3 = l1^-1/2, no tension leaves l3 = 1.
      const double taut = !scene.balloon.membrane.relaxed ? 1.0 / std::sqrt(k.i3)
                          : large <= 1.0                  ? 1.0
                                         : std::min(1.0 / std::sqrt(k.i3), 1.0 / std::sqrt(large));
      thickness += w * scene.balloon.thickness * taut;
    }
    state.thickness[v] = thickness / weight;
    state.stretch_1[v] = first / weight;
    state.stretch_2[v] = second / weight;
  }
  return state;
}

std::vector<double> plastic_strain(const Scene& scene, const State& state) {
  std::vector<double> by_slab(state.plastic.size());
  for (std::size_t c = 0; c < by_slab.size(); ++c) {
    ShapeMap<double> plastic;
    plastic.linear = state.plastic[c];
    if (!state.plastic_modes.empty())
      std::copy_n(state.plastic_modes.begin() + std::ptrdiff_t(c) * kShapeModes, kShapeModes,
                  plastic.modes);
    by_slab[c] = strain_size(plastic);
  }
  std::vector<double> result(std::size_t(scene.bodies.wall().count), 0.0);
  const WallSlabs& slabs = scene.wall.slabs;
  for (std::size_t v = 0; v < result.size(); ++v) {
    for (int n = slabs.slab_vertex_begin[v]; n < slabs.slab_vertex_begin[v + 1]; ++n)
      result[v] +=
          by_slab[std::size_t(slabs.slab_of[std::size_t(slabs.slab_vertices[std::size_t(n)])])];
    result[v] /= double(slabs.slab_vertex_begin[v + 1] - slabs.slab_vertex_begin[v]);
  }
  return result;
}

std::vector<WallStress> solid_stresses(const Scene& scene, const State& state) {
  SolidModel model = scene.wall.solid.model;
  model.points = state.solid_points;
  WallState wall;
  wall.vertices.assign(state.x.begin() + scene.bodies.wall().first, state.x.end());
  wall.plastic_strain = state.solid_plastic_strain;
  return wedge_stresses(model, scene.wall.solid.wall, wall);
}

}  // namespace angio::simulation::detail

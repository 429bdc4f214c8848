#include "centerline/detail/surface_wall.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "core/error.hpp"

namespace angio::centerline {
namespace {

void check_numbers(const TriangleMesh& surface) {
  const int count = int(surface.vertices.size());
  for (const Triangle& t : surface.triangles)
    for (const int v : t)
      if (v < 0 || v >= count)
        throw InputError("a triangle of the surface names vertex " + std::to_string(v) + " of " +
                         std::to_string(count) +
                         " (so the file is broken). Export the surface again");
  for (const Vec3& p : surface.vertices)
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      throw InputError(
          "a vertex of the surface is not a number (so the file is broken). Export the surface "
          "again");
}

/// Vertices within a millionth of the surface's size are one: writers of STL round each triangle on
/// its own.
TriangleMesh join_vertices(const TriangleMesh& surface) {
  double size = 0.0;
  for (const Vec3& p : surface.vertices)
    size = std::max(size, distance(p, surface.vertices.front()));
  const double cell = std::max(1e-6 * size, 1e-300);
  TriangleMesh joined;
  std::map<std::array<std::int64_t, 3>, int> index_of;
  std::vector<int> index(surface.vertices.size());
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
    const Vec3 p = (surface.vertices[v] - surface.vertices.front()) / (2.0 * cell);
    index[v] = -1;
    // The vertex is in one of the eight cells round it when it is within half a cell.
    for (int corner = 0; corner < 8 && index[v] < 0; ++corner) {
      const auto key = [&](int axis) {
        return std::int64_t(std::floor(p[axis] + ((corner >> axis & 1) != 0 ? 0.25 : -0.25)));
      };
      const auto found = index_of.find({key(0), key(1), key(2)});
      if (found != index_of.end()) index[v] = found->second;
    }
    if (index[v] >= 0) continue;
    index[v] = int(joined.vertices.size());
    index_of[{std::int64_t(std::floor(p.x)), std::int64_t(std::floor(p.y)),
              std::int64_t(std::floor(p.z))}] = index[v];
    joined.vertices.push_back(surface.vertices[v]);
  }
  for (const Triangle& t : surface.triangles) {
    const Triangle u{index[std::size_t(t[0])], index[std::size_t(t[1])], index[std::size_t(t[2])]};
    if (u[0] != u[1] && u[1] != u[2] && u[2] != u[0]) joined.triangles.push_back(u);
  }
  return joined;
}

/// Turns the triangles of each piece the way of its first one.
void turn_alike(TriangleMesh& mesh) {
  std::vector<std::array<int, 3>> neighbors = triangle_neighbors(mesh);
  std::vector<char> seen(mesh.triangles.size(), 0);
  const auto runs = [&](const Triangle& t, int a, int b) {
    return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
  };
  for (std::size_t seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (seen[seed] != 0) continue;
    seen[seed] = 1;
    std::vector<int> queue{int(seed)};
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const auto here = std::size_t(queue[next]);
      const Triangle t = mesh.triangles[here];
      for (std::size_t c = 0; c < 3; ++c) {
        const int other = neighbors[here][c];
        if (other < 0 || seen[std::size_t(other)] != 0) continue;
        seen[std::size_t(other)] = 1;
        Triangle& u = mesh.triangles[std::size_t(other)];
        if (runs(u, t[c], t[(c + 1) % 3])) {
          std::swap(u[1], u[2]);
          std::swap(neighbors[std::size_t(other)][0], neighbors[std::size_t(other)][2]);
        }
        queue.push_back(other);
      }
    }
  }
}

void close_rims(TriangleMesh& mesh) {
  for (const std::vector<int>& loop : boundary_loops(mesh)) {
    Vec3 middle;
    for (const int v : loop) middle += mesh.vertices[std::size_t(v)];
    const int center = int(mesh.vertices.size());
    mesh.vertices.push_back(middle / double(loop.size()));
    for (std::size_t i = 0; i < loop.size(); ++i)
      mesh.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], center});
  }
}

}  // namespace

ClosedSurface close_surface(const TriangleMesh& surface) {
  ClosedSurface closed;
  TriangleMesh& mesh = closed.mesh;
  check_numbers(surface);
  mesh = join_vertices(surface);
  turn_alike(mesh);
  closed.wall_vertex_count = int(mesh.vertices.size());
  close_rims(mesh);
  const double volume = enclosed_volume(mesh);
  if (!(std::abs(volume) > 0.0))
    throw InputError(
        "the surface encloses nothing (it is empty or flat, so there is no lumen). Give the "
        "surface of a vessel");
  if (volume < 0.0)
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return closed;
}

SurfaceWall::SurfaceWall(TriangleMesh closed, double resolution)
    : mesh_(std::move(closed)), resolution_(resolution) {
  const std::size_t count = mesh_.triangles.size();
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0);
  middle_.reserve(count);
  double edges = 0.0;
  for (const Triangle& t : mesh_.triangles) {
    const Vec3 &a = mesh_.vertices[std::size_t(t[0])], &b = mesh_.vertices[std::size_t(t[1])],
               &c = mesh_.vertices[std::size_t(t[2])];
    middle_.push_back((a + b + c) / 3.0);
    edges += (distance(a, b) + distance(b, c) + distance(c, a)) / 3.0;
  }
  if (resolution_ <= 0.0) resolution_ = 0.5 * edges / double(count);
  boxes_.push_back({{}, {}, -1, 0, int(count)});
  for (int box = 0; box < int(boxes_.size()); ++box) split(box);
}

void SurfaceWall::split(int index) {
  constexpr int kLeaf = 4;
  const double huge = std::numeric_limits<double>::max();
  Box box = boxes_[std::size_t(index)];
  box.low = {huge, huge, huge};
  box.high = -box.low;
  Vec3 low = box.low, high = box.high;  // of the triangles' middles
  for (int i = box.first; i < box.first + box.count; ++i) {
    const auto t = std::size_t(order_[std::size_t(i)]);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int v : mesh_.triangles[t]) {
        box.low[axis] = std::min(box.low[axis], mesh_.vertices[std::size_t(v)][axis]);
        box.high[axis] = std::max(box.high[axis], mesh_.vertices[std::size_t(v)][axis]);
      }
      low[axis] = std::min(low[axis], middle_[t][axis]);
      high[axis] = std::max(high[axis], middle_[t][axis]);
    }
  }
  const Vec3 extent = high - low;
  const int axis =
      extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
  if (box.count > kLeaf && extent[axis] > 0.0) {
    const int half = box.count / 2;
    const auto begin = order_.begin() + box.first;
    std::nth_element(begin, begin + half, begin + box.count, [&](int a, int b) {
      const double ma = middle_[std::size_t(a)][axis], mb = middle_[std::size_t(b)][axis];
      return ma != mb ? ma < mb : a < b;
    });
    box.left = int(boxes_.size());
    boxes_.push_back({{}, {}, -1, box.first, half});
    boxes_.push_back({{}, {}, -1, box.first + half, box.count - half});
  }
  boxes_[std::size_t(index)] = box;
}

namespace {

/// Moeller and Trumbore's ray-triangle test; negative when missed.
double hit_triangle(const Vec3& from, const Vec3& direction, const Vec3& a, const Vec3& b,
                    const Vec3& c) {
  const Vec3 e1 = b - a, e2 = c - a;
  const Vec3 p = cross(direction, e2);
  const double det = dot(e1, p);
  if (det == 0.0) return -1.0;
  const Vec3 s = from - a;
  const double u = dot(s, p) / det;
  if (u < -1e-9 || u > 1.0 + 1e-9) return -1.0;  // edges belong to both sides
  const Vec3 q = cross(s, e1);
  const double v = dot(direction, q) / det;
  if (v < -1e-9 || u + v > 1.0 + 1e-9) return -1.0;
  return dot(e2, q) / det;
}

bool hits_box(const Vec3& from, const Vec3& inverse, const Vec3& low, const Vec3& high,
              double longest) {
  double enter = 0.0, leave = longest;
  for (int axis = 0; axis < 3; ++axis) {
    const double t0 = (low[axis] - from[axis]) * inverse[axis];
    const double t1 = (high[axis] - from[axis]) * inverse[axis];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return enter <= leave * (1.0 + 1e-12) + 1e-12;
}

/// 1 / x without the 0 * infinity that a zero component would give in the box test.
double safe_inverse(double x) { return std::abs(x) > 1e-300 ? 1.0 / x : 1e300; }

}  // namespace

double SurfaceWall::first_hit(const Vec3& from, const Vec3& direction, double nearest_allowed,
                              double longest, int& triangle) const {
  const Vec3 inverse{safe_inverse(direction.x), safe_inverse(direction.y),
                     safe_inverse(direction.z)};
  triangle = -1;
  int stack[128];
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const Box& box = boxes_[std::size_t(stack[--depth])];
    if (!hits_box(from, inverse, box.low, box.high, longest)) continue;
    if (box.left >= 0) {
      stack[depth++] = box.left;
      stack[depth++] = box.left + 1;
      continue;
    }
    for (int i = box.first; i < box.first + box.count; ++i) {
      const int t = order_[std::size_t(i)];
      const Triangle& corners = mesh_.triangles[std::size_t(t)];
      const double hit = hit_triangle(from, direction, mesh_.vertices[std::size_t(corners[0])],
                                      mesh_.vertices[std::size_t(corners[1])],
                                      mesh_.vertices[std::size_t(corners[2])]);
      if (hit >= nearest_allowed && (hit < longest || (hit == longest && t < triangle))) {
        longest = hit;
        triangle = t;
      }
    }
  }
  return longest;
}

double SurfaceWall::ray(const Vec3& from, const Vec3& direction, double longest) const {
  int triangle = -1;
  // A point outside shows by this: what it hits first turns its front to it.
  const double hit = first_hit(from, direction, 0.0, longest, triangle);
  if (triangle < 0) return longest;
  const Vec3 normal = area_vector_doubled(mesh_, mesh_.triangles[std::size_t(triangle)]);
  return dot(normal, direction) > 0.0 ? hit : 0.0;
}

double SurfaceWall::distance_to_wall(const Vec3& point, int first_cap_vertex) const {
  const auto to_box = [&](int index) {
    const Box& box = boxes_[std::size_t(index)];
    double squared = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = std::max({box.low[axis] - point[axis], point[axis] - box.high[axis], 0.0});
      squared += d * d;
    }
    return squared;
  };
  double nearest = std::numeric_limits<double>::max();
  std::vector<std::pair<double, int>> stack{{to_box(0), 0}};
  while (!stack.empty()) {
    const auto [away, index] = stack.back();
    stack.pop_back();
    if (away >= nearest) continue;
    const Box& box = boxes_[std::size_t(index)];
    if (box.left >= 0) {
      std::pair<double, int> near{to_box(box.left), box.left};
      std::pair<double, int> far{to_box(box.left + 1), box.left + 1};
      if (near > far) std::swap(near, far);
      stack.push_back(far);
      stack.push_back(near);
      continue;
    }
    for (int i = box.first; i < box.first + box.count; ++i) {
      const auto& [a, b, c] = mesh_.triangles[std::size_t(order_[std::size_t(i)])];
      if (std::max({a, b, c}) >= first_cap_vertex) continue;
      nearest = std::min(nearest, distance_squared(point, mesh_.vertices[std::size_t(a)],
                                                   mesh_.vertices[std::size_t(b)],
                                                   mesh_.vertices[std::size_t(c)]));
    }
  }
  return std::sqrt(nearest);
}

std::vector<double> SurfaceWall::diameters(int most) const {
  std::vector<double> result, short_ones;
  const std::size_t count = mesh_.triangles.size();
  const std::size_t stride = std::max<std::size_t>(1, count / std::size_t(most));
  double huge = 0.0;
  for (int axis = 0; axis < 3; ++axis) huge += boxes_[0].high[axis] - boxes_[0].low[axis];
  for (std::size_t t = 0; t < count; t += stride) {
    const Vec3 inward = -normalized(area_vector_doubled(mesh_, mesh_.triangles[t]));
    if (norm_squared(inward) == 0.0) continue;
    int triangle = -1;
    const double hit = first_hit(middle_[t], inward, 1e-6 * huge, huge, triangle);
    // Folds of a noisy wall face each other at less than an edge; a vessel is wider than that.
    const auto& [a, b, c] = mesh_.triangles[t];
    const double edge = (distance(mesh_.vertices[std::size_t(a)], mesh_.vertices[std::size_t(b)]) +
                         distance(mesh_.vertices[std::size_t(b)], mesh_.vertices[std::size_t(c)]) +
                         distance(mesh_.vertices[std::size_t(c)], mesh_.vertices[std::size_t(a)])) /
                        3.0;
    if (triangle >= 0) (hit > 1.2 * edge ? result : short_ones).push_back(hit);
  }
  if (result.empty()) result = std::move(short_ones);
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace angio::centerline

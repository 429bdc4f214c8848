#include "meshing/detail/surface_query.hpp"

#include <CGAL/AABB_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace angio::meshing::detail {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;
namespace pmp = CGAL::Polygon_mesh_processing;

Point to_cgal(const Vec3& p) { return {p.x, p.y, p.z}; }
Vec3 from_cgal(const Point& p) { return {p.x(), p.y(), p.z()}; }

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

using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using AabbTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

}  // namespace

std::vector<std::array<int, 2>> self_intersections(const TriangleMesh& mesh) {
  const Triangles triangles = to_triangles(mesh);
  const std::vector<char> degenerate = degenerate_triangles(mesh, triangles);
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (degenerate[t]) pairs.push_back({int(t), int(t)});
  std::vector<Box> boxes = to_boxes(triangles);
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
    const auto i = std::size_t(a.handle() - triangles.begin());
    const auto j = std::size_t(b.handle() - triangles.begin());
    if (degenerate[i] || degenerate[j]) return;
    if (cross_beyond_shared(triangles, mesh.triangles[i], mesh.triangles[j], i, j))
      pairs.push_back({int(std::min(i, j)), int(std::max(i, j))});
  });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<std::array<int, 2>> self_intersections_of(const TriangleMesh& mesh,
                                                      const std::vector<char>& marked) {
  // Only triangles in the box around the marked ones can meet them.
  Vec3 low{1e300, 1e300, 1e300};
  Vec3 high = -low;
  for (std::size_t t = 0; t < marked.size(); ++t)
    if (marked[t])
      for (const int v : mesh.triangles[t])
        for (int axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], mesh.vertices[std::size_t(v)][axis]);
          high[axis] = std::max(high[axis], mesh.vertices[std::size_t(v)][axis]);
        }
  TriangleMesh near{mesh.vertices, {}};
  std::vector<int> index;
  for (std::size_t t = 0; t < marked.size(); ++t) {
    bool apart = false;
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = [&](std::size_t c) {
        return mesh.vertices[std::size_t(mesh.triangles[t][c])][axis];
      };
      apart |= std::max({at(0), at(1), at(2)}) < low[axis] ||
               std::min({at(0), at(1), at(2)}) > high[axis];
    }
    if (apart) continue;
    near.triangles.push_back(mesh.triangles[t]);
    index.push_back(int(t));
  }
  std::vector<std::array<int, 2>> pairs;
  for (const auto& [a, b] : self_intersections(near)) {
    const int i = index[std::size_t(a)];
    const int j = index[std::size_t(b)];
    if (marked[std::size_t(i)] || marked[std::size_t(j)]) pairs.push_back({i, j});
  }
  return pairs;
}

std::vector<std::array<int, 2>> sharp_folds(const TriangleMesh& mesh) {
  constexpr double kCosine = -0.82;  // of the angle between the normals: 145 degrees
  struct Side {
    int low, high, triangle;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = mesh.triangles[t][c];
      const int b = mesh.triangles[t][(c + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), int(t)});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    if (sides[i].low != sides[i + 1].low || sides[i].high != sides[i + 1].high) continue;
    const Vec3 a = area_vector_doubled(mesh, mesh.triangles[std::size_t(sides[i].triangle)]);
    const Vec3 b = area_vector_doubled(mesh, mesh.triangles[std::size_t(sides[i + 1].triangle)]);
    if (dot(a, b) < kCosine * norm(a) * norm(b))
      pairs.push_back({sides[i].triangle, sides[i + 1].triangle});
  }
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

std::vector<Triangle> triangulate_loop(const std::vector<Vec3>& loop) {
  std::vector<Point> points;
  points.reserve(loop.size());
  for (const Vec3& p : loop) points.push_back(to_cgal(p));
  struct IndexTriple {
    IndexTriple(int a, int b, int c) : corners{a, b, c} {}
    Triangle corners;
  };
  std::vector<IndexTriple> patch;
  pmp::triangulate_hole_polyline(points, std::back_inserter(patch));
  std::vector<Triangle> triangles;
  for (const IndexTriple& t : patch) triangles.push_back(t.corners);
  // Turn as the loop does: the loop's first edge says which way the patch came out.
  const int n = int(loop.size());
  for (const Triangle& t : triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      if (t[c] == 0 && t[(c + 1) % 3] == 1) return triangles;
      if (t[c] == 1 % n && t[(c + 1) % 3] == 0) {
        for (Triangle& flipped : triangles) std::swap(flipped[1], flipped[2]);
        return triangles;
      }
    }
  return triangles;
}

struct ClosestPoint::Tree {
  Triangles triangles;
  AabbTree tree;
};

ClosestPoint::ClosestPoint(const TriangleMesh& mesh) : tree_(std::make_unique<Tree>()) {
  tree_->triangles = to_triangles(mesh);
  tree_->tree.insert(tree_->triangles.cbegin(), tree_->triangles.cend());
  tree_->tree.build();
}

ClosestPoint::~ClosestPoint() = default;

ClosestPoint::Result ClosestPoint::find(const Vec3& point) const {
  const auto [nearest, primitive] = tree_->tree.closest_point_and_primitive(to_cgal(point));
  const Vec3 found = from_cgal(nearest);
  return {found, int(primitive - tree_->triangles.cbegin()), distance(found, point)};
}

}  // namespace angio::meshing::detail

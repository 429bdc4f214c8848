#include "meshing/detail/surface_query.hpp"

#include <CGAL/AABB_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <limits>
#include <tuple>

namespace angio::meshing::detail {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;

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

using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using AabbTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

}  // namespace

std::vector<std::array<int, 2>> sharp_folds_of(const TriangleMesh& mesh,
                                               const std::vector<char>& marked) {
  constexpr double kCosine = -0.82;  // of the angle between the normals: 145 degrees
  struct Side {
    int low, high, triangle;
  };
  std::vector<char> of_marked(mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (marked[t])
      for (const int v : mesh.triangles[t]) of_marked[std::size_t(v)] = 1;
  std::vector<Side> sides;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = mesh.triangles[t][c];
      const int b = mesh.triangles[t][(c + 1) % 3];
      if (!of_marked[std::size_t(a)] || !of_marked[std::size_t(b)]) continue;
      sides.push_back({std::min(a, b), std::max(a, b), int(t)});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    if (sides[i].low != sides[i + 1].low || sides[i].high != sides[i + 1].high) continue;
    if (!marked[std::size_t(sides[i].triangle)] && !marked[std::size_t(sides[i + 1].triangle)])
      continue;
    const Vec3 a = area_vector_doubled(mesh, mesh.triangles[std::size_t(sides[i].triangle)]);
    const Vec3 b = area_vector_doubled(mesh, mesh.triangles[std::size_t(sides[i + 1].triangle)]);
    if (dot(a, b) < kCosine * norm(a) * norm(b))
      pairs.push_back({sides[i].triangle, sides[i + 1].triangle});
  }
  return pairs;
}

std::vector<std::size_t> samples_of(const TriangleMesh& mesh, double area, int count) {
  std::vector<std::size_t> samples;
  double next = 0.5, passed = 0.0;  // in shares of the area, times the number of samples
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    passed += 0.5 * norm(area_vector_doubled(mesh, mesh.triangles[t])) / area * count;
    for (; next < passed; next += 1.0)
      if (samples.empty() || samples.back() != t) samples.push_back(t);
  }
  return samples;
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

double ClosestPoint::ahead(const Vec3& from, const Vec3& direction, int own_triangle) const {
  const auto own = tree_->triangles.cbegin() + own_triangle;
  const auto hit = tree_->tree.first_intersected_primitive(
      Kernel::Ray_3(to_cgal(from), Kernel::Vector_3(direction.x, direction.y, direction.z)),
      [&](const Triangles::const_iterator& t) { return t == own; });
  if (!hit) return std::numeric_limits<double>::infinity();
  const Kernel::Triangle_3& t = **hit;
  const Vec3 a = from_cgal(t[0]);
  const Vec3 normal = cross(from_cgal(t[1]) - a, from_cgal(t[2]) - a);
  const double along = dot(normal, direction);
  return along == 0.0 ? distance(from, a) : dot(normal, a - from) / along;
}

}  // namespace angio::meshing::detail

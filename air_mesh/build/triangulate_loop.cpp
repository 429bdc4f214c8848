#include "air_mesh/build/triangulate_loop.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <iterator>
#include <utility>

#include "air_mesh/build/patch_weight.hpp"

namespace angio::air_mesh {

std::vector<Triangle> triangulate_loop(const std::vector<Vec3>& loop) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  std::vector<Kernel::Point_3> points;
  points.reserve(loop.size());
  for (const Vec3& p : loop) points.emplace_back(p.x, p.y, p.z);
  struct IndexTriple {
    IndexTriple(int a, int b, int c) : corners{a, b, c} {}
    Triangle corners;
  };
  std::vector<IndexTriple> patch;
  std::vector<std::pair<int, int>> holes;
  CGAL::internal::Tracer_polyline_incomplete<IndexTriple,
                                             std::back_insert_iterator<decltype(patch)>,
                                             std::back_insert_iterator<decltype(holes)>>
      tracer(std::back_inserter(patch), std::back_inserter(holes));
  fill_loop<Kernel>(points, {}, CGAL::internal::Is_not_degenerate_triangle(), tracer);
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

}  // namespace angio::air_mesh

#include "meshing/detail/cap_rims.hpp"

#include <cstddef>

#include "air_mesh/build/triangulate_loop.hpp"
#include "core/error.hpp"

namespace angio::meshing::detail {

CappedMesh cap_rims(const TriangleMesh& open, const std::vector<int>& rim) {
  CappedMesh capped{open, std::vector<int>(open.vertices.size(), 0)};
  for (std::size_t v = 0; v < rim.size(); ++v) capped.id[v] = rim[v] + 1;
  for (const std::vector<int>& loop : boundary_loops(open)) {
    std::vector<Vec3> points;
    Vec3 centre;
    for (const int v : loop) {
      points.push_back(open.vertices[std::size_t(v)]);
      centre += points.back();
    }
    centre = centre / double(points.size());
    Vec3 area;
    for (std::size_t i = 0; i < points.size(); ++i)
      area += cross(points[i] - centre, points[(i + 1) % points.size()] - centre);
    bool star_shaped = true;
    for (std::size_t i = 0; i < points.size(); ++i)
      star_shaped &=
          dot(cross(points[i] - centre, points[(i + 1) % points.size()] - centre), area) > 0.0;
    std::vector<Triangle> patch;
    int split = -1;
    if (!star_shaped) {
      patch = air_mesh::triangulate_loop(points);
      if (patch.empty()) throw InternalError("a rim of the lumen could not be capped");
      // The centre goes into the largest triangle, so that each cap has a vertex of its own.
      double largest = 0.0;
      for (std::size_t t = 0; t < patch.size(); ++t) {
        const Vec3& a = points[std::size_t(patch[t][0])];
        const Vec3 n =
            cross(points[std::size_t(patch[t][1])] - a, points[std::size_t(patch[t][2])] - a);
        if (norm(n) <= largest) continue;
        largest = norm(n);
        split = int(t);
      }
    }
    const int centre_index = int(capped.mesh.vertices.size());
    const auto fan = [&](int a, int b) { capped.mesh.triangles.push_back({a, b, centre_index}); };
    if (star_shaped) {
      for (std::size_t i = 0; i < loop.size(); ++i) fan(loop[i], loop[(i + 1) % loop.size()]);
    }
    for (std::size_t t = 0; t < patch.size(); ++t) {
      const int a = loop[std::size_t(patch[t][0])];
      const int b = loop[std::size_t(patch[t][1])];
      const int c = loop[std::size_t(patch[t][2])];
      if (int(t) == split) {
        fan(a, b);
        fan(b, c);
        fan(c, a);
        centre = (open.vertices[std::size_t(a)] + open.vertices[std::size_t(b)] +
                  open.vertices[std::size_t(c)]) /
                 3.0;
      } else {
        capped.mesh.triangles.push_back({a, b, c});
      }
    }
    capped.mesh.vertices.push_back(centre);
    capped.id.push_back(rim[std::size_t(loop.front())] + 1);
  }
  return capped;
}

}  // namespace angio::meshing::detail

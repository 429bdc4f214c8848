#pragma once

#include <algorithm>

#include "core/tet_mesh.hpp"
#include "testing/simulation/models.hpp"

/// The gap between two tubes of the same pattern of triangles, meshed by prisms.
namespace angio::simulation::testing {

/// The prism of three tets behind each of an inner surface's triangles.
///
/// @param x       vertices of the inner surface, then those of the outer one
/// @param offset  the outer surface's first vertex
inline std::vector<Tet> prisms_behind(const std::vector<Triangle>& triangles, int offset,
                                      const std::vector<Vec3>& x) {
  const auto at = [&](int v) { return x[std::size_t(v)]; };
  std::vector<Tet> tets;
  for (Triangle t : triangles) {
    std::sort(t.begin(), t.end());  // the same diagonal from both sides of a prism's side
    const auto [a, b, c] = t;
    for (Tet tet : {Tet{a, b, c, c + offset}, Tet{a, b, b + offset, c + offset},
                    Tet{a, a + offset, b + offset, c + offset}}) {
      if (tet_volume(at(tet[0]), at(tet[1]), at(tet[2]), at(tet[3])) < 0.0)
        std::swap(tet[2], tet[3]);
      tets.push_back(tet);
    }
  }
  return tets;
}

struct Gap {
  TriangleMesh inner, outer;
  std::vector<Vec3> x;             ///< of the inner, then of the outer
  std::vector<Triangle> surfaces;  ///< of both
  std::vector<Tet> tets;

  [[nodiscard]] int inner_count() const { return int(inner.vertices.size()); }
  [[nodiscard]] double volume(const std::vector<Vec3>& at) const {
    TriangleMesh in = inner, out = outer;
    const auto middle = at.begin() + std::ptrdiff_t(in.vertices.size());
    in.vertices.assign(at.begin(), middle);
    out.vertices.assign(middle, middle + std::ptrdiff_t(out.vertices.size()));
    return enclosed_volume(out) - enclosed_volume(in);
  }
};

/// A tube of `length` and radius `inner` in one that is longer by `margin` at each end.
template <class Radius>
Gap make_gap(double length, double inner, const Radius& outer, double margin, int rings,
             int around) {
  Gap gap;
  gap.inner = closed_tube(length, rings, around, [&](double) { return inner; });
  gap.outer = closed_tube(length + 2.0 * margin, rings, around, outer);
  gap.x = gap.inner.vertices;
  gap.x.insert(gap.x.end(), gap.outer.vertices.begin(), gap.outer.vertices.end());
  gap.surfaces = gap.inner.triangles;
  const int n = gap.inner_count();
  for (const Triangle& t : gap.outer.triangles)
    gap.surfaces.push_back({t[0] + n, t[1] + n, t[2] + n});
  gap.tets = prisms_behind(gap.inner.triangles, n, gap.x);
  return gap;
}

}  // namespace angio::simulation::testing

#pragma once

#include <algorithm>
#include <array>

#include "tests/simulation/models.hpp"

/// A balloon in a tube of the same pattern of triangles: the gap is a layer of prisms, three air
/// tets each.
namespace angio::simulation::testing {

/// The tets between triangles i of two surfaces; `offset` is the second one's first vertex.
inline std::vector<Tet> prisms_between(const TriangleMesh& inner, const TriangleMesh& outer,
                                       std::size_t triangle_count) {
  const int offset = int(inner.vertices.size());
  const auto at = [&](int v) {
    return v < offset ? inner.vertices[std::size_t(v)] : outer.vertices[std::size_t(v - offset)];
  };
  std::vector<Tet> tets;
  for (std::size_t i = 0; i < triangle_count; ++i) {
    Triangle t = inner.triangles[i];
    std::sort(t.begin(), t.end());  // the diagonals of neighbours then agree
    for (Tet tet :
         {Tet{t[0], t[1], t[2], t[2] + offset}, Tet{t[0], t[1], t[1] + offset, t[2] + offset},
          Tet{t[0], t[0] + offset, t[1] + offset, t[2] + offset}}) {
      if (tet_volume(at(tet[0]), at(tet[1]), at(tet[2]), at(tet[3])) < 0.0)
        std::swap(tet[0], tet[1]);
      tets.push_back(tet);
    }
  }
  return tets;
}

/// A rubber balloon, unfolded, in a straight tube whose rings are `step` mm apart, with the air
/// mesh between them.
inline SimulationModel matched_model(double start_radius, double lumen_radius, int rings = 15,
                                     int around = 14, double step = 0.375) {
  StenosedTube p;
  p.radius = lumen_radius;
  p.length = (rings - 1) * step;
  p.stenosis = 0.0;
  p.start_radius = start_radius;
  p.balloon_length = (rings + 1) * step;
  p.balloon_rings = p.wall_rings = rings;
  p.balloon_around = p.wall_around = around;
  SimulationModel model = make_model(p);
  model.balloon_rest = model.balloon.vertices;
  model.air = prisms_between(model.balloon, model.wall, model.wall.triangles.size());
  return model;
}

}  // namespace angio::simulation::testing

#pragma once

#include <cmath>

#include "testing/simulation/models.hpp"

/// A balloon in a narrowed vessel whose wall is the layered solid.
namespace angio::simulation::testing {

/// The lumen extruded to the healthy wall's outside: plaque where it is narrow.
inline LayeredWall extruded(const TriangleMesh& lumen, const std::vector<char>& fixed,
                            double radius, double ratio) {
  const std::vector<double> level = {0.0, 0.35, 0.65, 1.0};
  const double outside = radius / (1.0 - 2.0 * ratio);
  const int count = int(lumen.vertices.size());
  LayeredWall wall;
  wall.lumen_triangles = lumen.triangles;
  for (const double share : level)
    for (int v = 0; v < count; ++v) {
      const Vec3 p = lumen.vertices[std::size_t(v)];
      const double inner = std::hypot(p.x, p.y), r = inner + share * (outside - inner);
      wall.vertices.push_back({p.x * r / inner, p.y * r / inner, p.z});
      wall.fixed.push_back(fixed[std::size_t(v)] != 0 ? 1 : 0);
    }
  for (int layer = 0; layer < 3; ++layer)
    for (const Triangle& t : lumen.triangles) {
      const int in = layer * count, out = in + count;
      wall.wedges.push_back({t[0] + in, t[1] + in, t[2] + in, t[0] + out, t[1] + out, t[2] + out});
      wall.layer.push_back(layer);
      const Vec3 p = lumen.vertices[std::size_t(t[0])];
      const bool narrow = std::hypot(p.x, p.y) < 0.9 * radius;
      wall.region.push_back(layer == 0 && narrow ? WallRegion::plaque : WallRegion(layer));
      wall.axial.push_back({0, 0, 1});
    }
  for (const Triangle& t : lumen.triangles)
    wall.outer_triangles.push_back({t[0] + 3 * count, t[1] + 3 * count, t[2] + 3 * count});
  return wall;
}

/// A small one: 156 columns.
inline StenosedTube layered_tube() {
  StenosedTube p;
  p.length = 7.0;
  p.lesion_length = 4.0;
  p.balloon_length = 4.0;
  p.balloon_rings = 10;
  p.balloon_around = 10;
  p.wall_rings = 13;
  p.wall_around = 12;
  p.stenosis = 0.4;
  return p;
}

inline SimulationModel layered_model(const StenosedTube& p = layered_tube()) {
  SimulationModel model = make_model(p);
  model.layered_wall = extruded(model.wall, model.wall_fixed, p.radius, 0.189);
  return model;
}

/// With a balloon that is blown up unfolded: a wrapped one's shape while it is slack is not
/// determined (docs/validation.md).
inline void use_rubber(SimulationModel& model, SimulationOptions& options) {
  model.balloon_rest = model.balloon.vertices;
  options.balloon.name = "polyurethane";
  options.inflation.peak_pressure_atm = 8.0;
}

inline SimulationOptions layered_options() {
  SimulationOptions options;
  options.backend = Backend::cpu;
  options.frame_s = 0.1;
  options.inflation.inflate_s = 1.0;
  options.inflation.hold_s = 0.1;
  options.inflation.deflate_s = 0.6;
  options.inflation.rest_s = 0.1;
  options.inflation.peak_pressure_atm = 6.0;
  return options;
}

}  // namespace angio::simulation::testing

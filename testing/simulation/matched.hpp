#pragma once

#include <cmath>

#include "testing/simulation/meshed_gap.hpp"

/// A balloon in a vessel of the same pattern of triangles, so that an air mesh needs no mesher.
namespace angio::simulation::testing {

/// A rubber balloon, unfolded, in a straight tube, with air tets between those triangles that face
/// each other: the balloon's ends have none, so that the mesh is not whole.
inline SimulationModel matched_model(double start_radius, double lumen_radius) {
  constexpr int kRings = 15, kAround = 14;
  constexpr double kLength = 6.0, kStep = kLength / (kRings + 1);
  StenosedTube p;
  p.radius = lumen_radius;
  p.length = (kRings - 1) * kStep;
  p.stenosis = 0.0;
  p.start_radius = start_radius;
  p.balloon_length = kLength;
  p.balloon_rings = p.wall_rings = kRings;
  p.balloon_around = p.wall_around = kAround;
  SimulationModel model = make_model(p);
  model.balloon_rest = model.balloon.vertices;
  std::vector<Vec3> x = model.balloon.vertices;
  x.insert(x.end(), model.wall.vertices.begin(), model.wall.vertices.end());
  const auto first = model.balloon.triangles.begin();
  model.air = prisms_behind({first, first + std::ptrdiff_t(model.wall.triangles.size())},
                            int(model.balloon.vertices.size()), x);
  return model;
}

/// A rubber balloon, unfolded, in a vessel of the same pattern of triangles, `step` mm a ring, that
/// is closed and held at its ends; the gap between them is an air mesh of prisms.
inline SimulationModel model_in_a_bag(double start_radius, double lumen_radius, int rings = 15,
                                      int around = 14, double step = 0.375) {
  const Gap gap = make_gap((rings + 1) * step, start_radius, [&](double) { return lumen_radius; },
                           0.5 * step, rings, around);
  SimulationModel model;
  model.balloon = gap.inner;
  model.balloon_rest = gap.inner.vertices;
  model.balloon_fixed.assign(gap.inner.vertices.size(), 0);
  model.balloon_fixed.back() = model.balloon_fixed.end()[-2] = 1;
  model.wall = gap.outer;
  model.air = gap.tets;
  const double end = std::abs(gap.outer.vertices.front().z);
  for (const Vec3& v : gap.outer.vertices) {
    model.wall_fixed.push_back(std::abs(v.z) > end - 1e-6);
    model.wall_abscissa.push_back(v.z + end);
    model.wall_group.push_back(0);
  }
  model.guidewire = {gap.inner.vertices.end()[-2], gap.inner.vertices.back()};
  model.reference_radius_mm = lumen_radius;
  model.measure_tangent = {0, 0, 1};
  return model;
}

/// A short inflation of such a balloon, from its start to 4 atm and back in 1.2 s.
inline SimulationOptions rubber_options(Backend backend) {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.balloon.wall_mm = 0.04;
  options.inflation.peak_pressure_atm = 4.0;
  options.inflation.inflate_s = options.inflation.deflate_s = 0.5;
  options.inflation.hold_s = options.inflation.rest_s = 0.1;
  options.backend = backend;
  return options;
}

}  // namespace angio::simulation::testing

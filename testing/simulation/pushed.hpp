#pragma once

#include <cmath>
#include <vector>

#include "core/units.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/step/make_views.hpp"
#include "testing/simulation/gaps.hpp"
#include "testing/simulation/models.hpp"

/// A balloon led by the hand through a lumen: each frame its vertices get the velocities of a screw
/// motion along the vessel.
namespace angio::simulation::testing {

struct Screw {
  double turn = 0.0;   ///< a frame, around z [rad]
  double shift = 0.0;  ///< a frame, along z [mm]
  int from_frame = 1, frames = 0;
};

struct Led {
  std::vector<SimulationFrame> frames;  ///< positions and contact pressure only
};

inline Led lead(const SimulationModel& model, const SimulationOptions& options,
                const Screw& screw) {
  const detail::Scene scene = detail::make_scene(model, options);
  const auto solver = detail::make_cpu_solver(scene, options);
  solver->set_push([&](int frame, const std::vector<Vec3>& x, std::vector<Vec3>& velocity) {
    if (frame < screw.from_frame || frame >= screw.from_frame + screw.frames) return;
    const double c = std::cos(screw.turn), s = std::sin(screw.turn);
    for (std::size_t v = 0; v < std::size_t(scene.bodies.balloon().count); ++v) {
      const Vec3 p = x[v];
      const Vec3 to{c * p.x - s * p.y, s * p.x + c * p.y, p.z + screw.shift};
      velocity[v] = (to - p) / options.frame_s;
    }
  });
  const double volume = detail::balloon_volume(scene, scene.start);
  Led led;
  solver->run(detail::make_control(scene, options, 1.3 * volume),
              [&](int frame, const detail::State& state) {
                SimulationFrame out;
                out.frame = frame;
                out.balloon.resize(std::size_t(scene.bodies.balloon().count));
                out.wall.resize(std::size_t(scene.bodies.wall().count));
                out.contact_pressure_kpa.resize(std::size_t(scene.bodies.wall().count));
                for (std::size_t v = 0; v < scene.caller_vertex.size(); ++v) {
                  const auto to = std::size_t(scene.caller_vertex[v]);
                  const bool balloon = v < std::size_t(scene.bodies.balloon().count);
                  (balloon ? out.balloon : out.wall)[to] = state.x[v];
                  if (!balloon)
                    out.contact_pressure_kpa[to] = units::kilopascal_from_pascal(
                        state.contact_pressure[v - std::size_t(scene.bodies.wall().first)]);
                }
                out.contact.count = state.report.contact_count;
                led.frames.push_back(std::move(out));
              });
  return led;
}

/// A balloon of radius `start_radius`, unfolded, in a straight tube; nothing of it is held.
inline SimulationModel loose_balloon(double start_radius, double lumen_radius) {
  StenosedTube p;
  p.radius = lumen_radius;
  p.length = 20.0;
  p.stenosis = 0.0;
  p.lesion_length = 4.0;
  p.start_radius = start_radius;
  p.balloon_length = 6.0;
  p.balloon_rings = 14;
  p.balloon_around = 16;
  p.wall_rings = 51;
  p.wall_around = 20;
  SimulationModel model = make_model(p);
  model.balloon_rest = model.balloon.vertices;
  model.balloon_fixed.assign(model.balloon.vertices.size(), 0);
  return model;
}

inline SimulationModel without_wall(SimulationModel model) {
  model.wall = {};
  model.wall_fixed.clear();
  model.wall_abscissa.clear();
  model.wall_group.clear();
  return model;
}

/// The schedule of a balloon that is only led: `seconds` of rest at (almost) no pressure.
inline SimulationOptions led_options(double seconds) {
  SimulationOptions options;
  options.inflation.control = InflationControl::pressure;
  options.inflation.peak_pressure_atm = 0.01;
  options.inflation.inflate_s = options.frame_s;
  options.inflation.hold_s = seconds;
  options.inflation.deflate_s = options.frame_s;
  options.inflation.rest_s = 0.0;
  return options;
}

/// How far a led balloon strays from where the same lead takes it in free space, over the longest
/// way of a vertex.
inline double hindrance(const SimulationModel& model, const SimulationOptions& options,
                        const Screw& screw) {
  const Led inside = lead(model, options, screw), free = lead(without_wall(model), options, screw);
  double worst = 0.0, longest = 0.0;
  std::vector<double> way(model.balloon.vertices.size(), 0.0);
  for (std::size_t f = 1; f < inside.frames.size(); ++f)
    for (std::size_t v = 0; v < way.size(); ++v) {
      way[v] += distance(free.frames[f].balloon[v], free.frames[f - 1].balloon[v]);
      longest = std::max(longest, way[v]);
      worst = std::max(worst, distance(inside.frames[f].balloon[v], free.frames[f].balloon[v]));
    }
  return worst / longest;
}

}  // namespace angio::simulation::testing

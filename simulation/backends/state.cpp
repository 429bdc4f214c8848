#include "simulation/backends/state.hpp"

namespace angio::simulation::detail {

double balloon_volume(const Scene& scene, const std::vector<Vec3>& x) {
  double volume = 0.0;
  const Vec3 origin = x[0];
  for (const Triangle& t : scene.balloon.triangles)
    volume += dot(x[std::size_t(t[0])] - origin,
                  cross(x[std::size_t(t[1])] - origin, x[std::size_t(t[2])] - origin));
  return volume / 6.0;
}

State start_state(const Scene& scene, double pressure) {
  State state;
  state.x = scene.start;
  state.plastic.assign(std::size_t(scene.wall.slabs.count()), Mat3::identity());
  state.contact_pressure.assign(std::size_t(scene.bodies.wall().count), 0.0);
  state.solid_points = scene.wall.solid.model.points;
  state.solid_plastic_strain.assign(state.solid_points.size(), 0.0);
  state.pressure = pressure;
  state.volume = balloon_volume(scene, state.x);
  return state;
}

}  // namespace angio::simulation::detail

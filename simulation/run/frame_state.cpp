#include "simulation/run/frame_state.hpp"

#include <vector>

#include "core/units.hpp"
#include "simulation/run/balloon_section.hpp"
#include "simulation/run/measure.hpp"

namespace angio::simulation::detail {
namespace {

// From the scene's order of vertices to the caller's; `first` is the surface's first vertex.
template <class Value>
std::vector<Value> for_caller(const Scene& scene, int first, const std::vector<Value>& values) {
  std::vector<Value> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    result[std::size_t(scene.caller_vertex[std::size_t(first) + i])] = values[i];
  return result;
}

// A layered wall's shape and plastic strain, and how to find its stress.
void add_solid(const std::shared_ptr<const Scene>& shared_scene,
               const std::shared_ptr<const State>& shared_state, SimulationFrame& frame) {
  const Scene& scene = *shared_scene;
  const State& state = *shared_state;
  frame.wall_stress = [shared_scene, shared_state] {
    return solid_stresses(*shared_scene, *shared_state);
  };
  const WallSolid& solid = scene.wall.solid;
  const int first = scene.bodies.wall().first;
  frame.layered_wall.resize(solid.caller_vertex.size());
  for (std::size_t v = 0; v < frame.layered_wall.size(); ++v)
    frame.layered_wall[std::size_t(solid.caller_vertex[v])] = state.x[std::size_t(first) + v];
  std::vector<double> plastic = vertex_means(
      solid.model, solid.wall, wedge_plastic_strain(solid.model, state.solid_plastic_strain));
  plastic.resize(std::size_t(scene.bodies.wall().count));
  frame.plastic_strain = for_caller(scene, first, plastic);
}

}  // namespace

void add_state(const SimulationModel& model, const std::shared_ptr<const Scene>& shared_scene,
               const std::shared_ptr<const State>& shared_state, double outside,
               SimulationFrame& frame) {
  const Scene& scene = *shared_scene;
  const State& state = *shared_state;
  frame.pressure_atm = units::atm_from_pascal(state.pressure - outside);
  frame.balloon_volume_mm3 = state.volume;
  frame.balloon_diameter_mm = diameter_across(scene.balloon.triangles, state.x, model.measure_point,
                                              normalized(model.measure_tangent));
  for (const WatchedPlace& end : model.balloon_ends)
    frame.end_diameters_mm.push_back(
        diameter_across(scene.balloon.triangles, state.x, end.point, normalized(end.tangent)));
  frame.contact.max_penetration_mm = max_penetration(scene, state.x);
  const int wall = scene.bodies.wall().first;
  const auto middle = state.x.begin() + wall;
  frame.balloon = for_caller(scene, 0, std::vector<Vec3>(state.x.begin(), middle));
  frame.wall =
      for_caller(scene, wall, std::vector<Vec3>(middle, middle + scene.bodies.wall().count));
  const auto wire = state.x.begin() + scene.bodies.guidewire().first;
  if (scene.rod.count > 0) frame.guidewire.assign(wire, wire + scene.rod.count);
  const MembraneState membrane = membrane_state(scene, state.x);
  frame.membrane.thickness_mm = for_caller(scene, 0, membrane.thickness);
  frame.membrane.stretch_1 = for_caller(scene, 0, membrane.stretch_1);
  frame.membrane.stretch_2 = for_caller(scene, 0, membrane.stretch_2);
  if (scene.wall.solid.levels > 0)
    add_solid(shared_scene, shared_state, frame);
  else
    frame.plastic_strain = for_caller(scene, wall, plastic_strain(scene, state));
  for (const double p : for_caller(scene, wall, state.contact_pressure))
    frame.contact_pressure_kpa.push_back(units::kilopascal_from_pascal(p));
  frame.residual = state.report.residual;
  frame.lag = state.report.lag;
  frame.sweep_count = state.report.sweeps;
  frame.contact.friction_delta_mm = state.report.friction_delta;
  frame.contact.viscous_delta_mm = state.report.viscous_delta;
  frame.contact.count = state.report.contact_count;
  frame.contact.area_mm2 = contact_area(scene, state);
}

}  // namespace angio::simulation::detail

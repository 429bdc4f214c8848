#include "pipeline/config/shared_quantities.hpp"

#include "simulation/balloon_size.hpp"

namespace angio::pipeline {

simulation::SimulationOptions solver_options(const simulation::SimulationOptions& asked,
                                             simulation::Plaque plaque, double shaft_diameter_mm,
                                             double nominal_diameter_mm) {
  simulation::SimulationOptions options = simulation::sized(asked, nominal_diameter_mm);
  options.guidewire.shaft_diameter_mm = shaft_diameter_mm;
  options.layered_wall.materials = simulation::wall_materials(plaque);
  options.layered_wall.foundation_kpa_per_mm = options.wall.foundation_kpa_per_mm;
  options.layered_wall.blood_pressure_kpa = options.inflation.outside_pressure_kpa;
  return options;
}

meshing::WallLayerOptions wall_layer_options(const meshing::WallLayerOptions& asked,
                                             double thickness_ratio) {
  meshing::WallLayerOptions options = asked;
  options.thickness_ratio = thickness_ratio;
  return options;
}

}  // namespace angio::pipeline

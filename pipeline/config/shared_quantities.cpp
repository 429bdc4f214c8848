#include "pipeline/config/shared_quantities.hpp"

#include "simulation/balloon_size.hpp"

namespace angio::pipeline {

bool is_usual_balloon(const simulation::BalloonMaterial& membrane, double rest_diameter_mm) {
  const simulation::BalloonMaterial usual;
  return membrane.chart.empty() && membrane.name == usual.name && !(membrane.c1_mpa > 0.0) &&
         !(rest_diameter_mm > 0.0);
}

meshing::BalloonOptions balloon_options(const meshing::BalloonOptions& asked, bool is_usual,
                                        double reference_diameter_mm) {
  meshing::BalloonOptions options = asked;
  if (!is_usual) return options;
  if (!(options.nominal_diameter_mm > 0.0))
    options.nominal_diameter_mm = meshing::usual_balloon_diameter_mm(reference_diameter_mm);
  options.rest_diameter_mm =
      simulation::rest_diameter_mm(simulation::balloon_size(options.nominal_diameter_mm).chart);
  return options;
}

simulation::SimulationOptions solver_options(const simulation::SimulationOptions& asked,
                                             simulation::Plaque plaque, double shaft_diameter_mm,
                                             double nominal_diameter_mm, bool is_usual) {
  simulation::SimulationOptions options = simulation::sized(asked, nominal_diameter_mm);
  if (is_usual) options.balloon.chart = simulation::balloon_size(nominal_diameter_mm).chart;
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

#pragma once

#include "meshing/wall_layers.hpp"
#include "simulation/simulation.hpp"

/// Quantities that more than one options struct has. Each has one key, one default and one range in
/// the configuration; here it comes to every struct.
namespace angio::pipeline {

/// The options of the solver. What both models of the wall need, and what both the balloon and the
/// wall need, is set once in the configuration: the surrounding tissue, the blood's pressure, the
/// shaft. What is left to the balloon's size is filled in.
simulation::SimulationOptions solver_options(const simulation::SimulationOptions& asked,
                                             simulation::Plaque plaque, double shaft_diameter_mm,
                                             double nominal_diameter_mm);

/// The options of the wall's layers. Both models of the wall are as thick as `wall.thickness_ratio`
/// says.
meshing::WallLayerOptions wall_layer_options(const meshing::WallLayerOptions& asked,
                                             double thickness_ratio);

}  // namespace angio::pipeline

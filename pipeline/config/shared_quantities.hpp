#pragma once

#include "meshing/meshing.hpp"
#include "meshing/wall_layers.hpp"
#include "simulation/simulation.hpp"

/// Quantities that more than one options struct has. Each has one key, one default and one range in
/// the configuration; here it comes to every struct.
namespace angio::pipeline {

/// Is the balloon the representative one of its diameter, with that one's compliance chart
/// (simulation::balloon_size)? Unless a chart, another material, a modulus or an unloaded diameter
/// is given.
///
/// @param membrane          as asked for
/// @param rest_diameter_mm  as asked for; 0: none
bool is_usual_balloon(const simulation::BalloonMaterial& membrane, double rest_diameter_mm);

/// The options of the balloon's meshes for a vessel. The diameters that are left to the vessel are
/// filled in where the balloon is a usual one: its nominal diameter, and that of its chart without
/// load.
meshing::BalloonOptions balloon_options(const meshing::BalloonOptions& asked, bool is_usual,
                                        double reference_diameter_mm);

/// The options of the solver. What both models of the wall need, and what both the balloon and the
/// wall need, is set once in the configuration: the surrounding tissue, the blood's pressure, the
/// shaft. What is left to the balloon's size is filled in, for a usual balloon its chart as well.
simulation::SimulationOptions solver_options(const simulation::SimulationOptions& asked,
                                             simulation::Plaque plaque, double shaft_diameter_mm,
                                             double nominal_diameter_mm, bool is_usual);

/// The options of the wall's layers. Both models of the wall are as thick as `wall.thickness_ratio`
/// says.
meshing::WallLayerOptions wall_layer_options(const meshing::WallLayerOptions& asked,
                                             double thickness_ratio);

}  // namespace angio::pipeline

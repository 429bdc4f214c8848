#pragma once

#include "simulation/simulation.hpp"

namespace angio::pipeline {

/// The options of the solver. What both models of the wall need, and what both the balloon and the
/// wall need, is set once in the configuration: the surrounding tissue, the blood's pressure, the
/// shaft. What is left to the balloon's size is filled in.
simulation::SimulationOptions solver_options(const simulation::SimulationOptions& asked,
                                             simulation::Plaque plaque, double shaft_diameter_mm,
                                             double nominal_diameter_mm);

}  // namespace angio::pipeline

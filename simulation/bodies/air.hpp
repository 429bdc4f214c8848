#pragma once

#include "air_mesh/adaptive_air.hpp"
#include "simulation/bodies/scene.hpp"

namespace angio::simulation::detail {

/// The air of a model, in the scene's numbering of balloon and wall.
air_mesh::AdaptiveAir make_air(const SimulationModel& model, const Scene& scene);

}  // namespace angio::simulation::detail

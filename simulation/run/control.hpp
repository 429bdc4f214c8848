#pragma once

#include "simulation/bodies/scene.hpp"
#include "simulation/run/schedule.hpp"
#include "simulation/step/status.hpp"

namespace angio::simulation::detail {

/// What drives a run. The model, which is constant, is Scene; what moves is State.
struct Control {
  Inflator inflator;  ///< the law of pressure or volume in each frame
  StepRules rules;    ///< when the sweeps of a frame end
};

/// @param nominal_volume  that the balloon is expected to fill [mm^3]
Control make_control(const Scene& scene, const SimulationOptions& options, double nominal_volume);

StepRules make_rules(const Scene& scene, const SimulationOptions& options);

/// Of one equilibrium, without inertia.
///
/// @param tolerance  of the remaining distance, as a share of the radius
StepRules settling_rules(const Scene& scene, const SimulationOptions& options, double tolerance,
                         int most_sweeps);

}  // namespace angio::simulation::detail

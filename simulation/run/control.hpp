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

/// What the balloon is expected to enclose when full: its rest shape. A balloon that starts
/// unfolded is blown up like a rubber one, to the vessel's radius in its middle; towards its poles,
/// which stay, it tapers like an ellipsoid over four radii.
/// @param start_volume  [mm^3] that it encloses at the start
/// @return [mm^3], at least start_volume
double expected_volume(const SimulationModel& model, const Scene& scene, double start_volume);

/// @param nominal_volume  that the balloon is expected to fill [mm^3]
Control make_control(const Scene& scene, const SimulationOptions& options, double nominal_volume);

StepRules make_rules(const Scene& scene, const SimulationOptions& options);

/// Of one equilibrium, without inertia.
///
/// @param tolerance  of the remaining distance, as a share of the radius
StepRules settling_rules(const Scene& scene, const SimulationOptions& options, double tolerance,
                         int most_sweeps);

}  // namespace angio::simulation::detail

#pragma once

#include <vector>

#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

/// What a balloon without a wall is held at: a pressure above the outside [Pa], or a volume [mm^3].
struct Load {
  enum class Kind { pressure, volume };
  Kind kind = Kind::pressure;
  double value = 0.0;
};

struct Equilibrium {
  std::vector<Vec3> x;     ///< [mm], shape [balloon vertex], in the model's order
  double pressure = 0.0;   ///< above the outside [Pa]: the load, or its answer to a volume
  double volume = 0.0;     ///< enclosed [mm^3]
  double residual = 0.0;   ///< net force over load, root of sums of squares
  double lag = 0.0;        ///< estimated distance still to go, as a share of the start radius
  int sweeps = 0;          ///< in all, over the steps that led there
  bool converged = false;  ///< lag and residual are below the tolerance
};

/// The shapes of a free balloon under a list of loads, one after the other, by vertex block descent
/// on `options.backend`: the steps of simulate() without inertia. A load far from the last one is
/// applied in increments.
///
/// Under pressure a balloon past its limit point has no equilibrium: that is reported as not
/// converged. A volume always has one.
///
/// @param model      the wall is not used
/// @param tolerance  of lag and residual; below about 1e-5 single precision has no say
/// @throws InputError for a model that is no balloon; OptionError for loads that are no numbers
std::vector<Equilibrium> find_equilibria(const SimulationModel& model,
                                         const SimulationOptions& options,
                                         const std::vector<Load>& loads, double tolerance = 1e-4,
                                         int most_sweeps = 4000);

}  // namespace angio::simulation::detail

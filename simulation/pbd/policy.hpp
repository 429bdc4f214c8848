#pragma once

#include <string>
#include <vector>

#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

/// Where the seed paper's methods stand in for the solver's own, and what this asks of the rest.
/// The solver asks nothing else about them; its steps ask PbdView (view.hpp) and call sweep.hpp.
struct PbdPolicy {
  bool contact = false;  ///< air tets are projected: no barrier, no film between balloon and wall
  bool gas = false;      ///< the gas of each tet is projected: no pressure drives the balloon

  /// What is projected never balances: sweeps are counted, no surface meets itself, and the run is
  /// not judged.
  [[nodiscard]] bool balances() const { return !contact && !gas; }
  /// The gas' tets do not settle: what one rounding changes is a millionfold larger at the end.
  [[nodiscard]] bool needs_double() const { return gas; }
  /// What its gas moves is no motion to go on with: the balloon would collapse.
  [[nodiscard]] bool goes_on() const { return !gas; }
};

/// Sweeps of a frame that never balances, where none are asked for.
inline constexpr int kPbdSweeps = 20;

PbdPolicy pbd_policy(const SimulationOptions& options);

/// @throws OptionError where the paper's gas is asked for what it cannot do
void validate_pbd(const SimulationOptions& options);

/// What is to be known of a result by these methods.
std::vector<std::string> pbd_warnings(const SimulationOptions& options);

}  // namespace angio::simulation::detail

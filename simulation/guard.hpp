#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "simulation/simulation.hpp"

/// Is what a simulation comes to determined? It is computed twice, from starts and with tolerances
/// that nobody could tell apart.
namespace angio::simulation {

/// How the second run differs from the first.
struct Disturbance {
  double move_mm = 1e-6;           ///< of each start vertex, in each direction at most, >= 0
  double tolerance_factor = 1.02;  ///< on SimulationOptions::tolerance, > 0
  std::uint64_t seed = 1;          ///< of the moves
};

/// The model with every vertex that may move put aside by up to `move_mm` in each direction, evenly
/// distributed. The balloon's rest shape and the copies of a wall vertex in a layered wall move
/// with it, so that a start at rest stays one and no layer changes its thickness.
SimulationModel disturbed(SimulationModel model, const Disturbance& by);

/// What two runs have come to.
struct GuardedSummary {
  SimulationSummary first;
  std::optional<SimulationSummary> second;  ///< unset: it did not end, or the first has failed
  std::string second_failure;               ///< why the second is no result; empty: it is one
};

/// The frames of a run, as they come.
using FrameSink = std::function<void(const SimulationFrame&)>;

/// simulate() twice, the second time disturbed and without following the air. On the CPU both run
/// at once and share the threads (results do not depend on their number); with one thread, and on a
/// GPU, which both would need whole, one after the other on the same backend. A layered wall's
/// pre-stress is found once, for both. The first run is bit
/// for bit that of simulate(). If it fails, the second is given up. Frames of the two runs may come
/// at once, each sink's own one at a time.
///
/// @throws what simulate() does for the first run; that the second one throws is second_failure
GuardedSummary simulate_guarded(const SimulationModel& given, const SimulationOptions& options,
                                const Disturbance& by, const FrameSink& on_frame,
                                const FrameSink& on_second_frame, const Progress& progress = {});

}  // namespace angio::simulation

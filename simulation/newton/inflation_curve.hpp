#pragma once

#include <vector>

#include "core/progress.hpp"
#include "simulation/inflate.hpp"
#include "simulation/newton/initial_capsule.hpp"
#include "simulation/newton/membrane_term.hpp"

/// The solvers behind the free inflation test bench.
namespace angio::simulation::detail {

struct FreeState {
  std::vector<Vec3> x;    ///< [mm], shape [vertex of the capsule]
  double pressure = 0.0;  ///< above the outside [Pa]
  double volume = 0.0;    ///< enclosed by the facets [mm^3]
  double residual = 0.0;
  bool converged = false;
};

enum class Hold { pressure, volume };  ///< [Pa], [mm^3]

/// The mesh of a balloon: a capsule, or a piece of a tube.
Capsule mesh_of(const FreeBalloon& balloon, int around);

/// The membrane's energy on it.
MembraneTerm membrane_of(const FreeBalloon& balloon, const Capsule& capsule);

/// A state of rest for each target, by options.solver.
///
/// @param capsule  of mesh_of(balloon, ...)
/// @param targets  rising [Pa] or [mm^3]
std::vector<FreeState> find_states(const FreeBalloon& balloon, const Capsule& capsule,
                                   const InflateOptions& options, Hold hold,
                                   const std::vector<double>& targets, const Progress& progress);

}  // namespace angio::simulation::detail

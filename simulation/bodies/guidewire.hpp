#pragma once

#include <vector>

#include "simulation/materials/rod.hpp"
#include "simulation/simulation.hpp"
#include "simulation/step/views.hpp"

namespace angio::simulation::detail {

/// The guidewire of a run: constants of its rod.
struct SceneRod {
  int count = 0;        ///< nodes; 0: there is none
  double radius = 0.0;  ///< of the shaft [mm]
  RodSection<double> section;
  std::vector<double> rest;  ///< [mm], shape [count - 1]
  std::vector<Vec3> bend;    ///< unloaded curvature binormals, shape [count]
  std::vector<double> mass;  ///< [g], shape [count]
  std::vector<char> held;    ///< shape [count]
  std::vector<RodTie> ties;  ///< the balloon's fixed vertices
};

/// A tube of the shaft's material around the wire: both bend, the shaft alone is stretched (the
/// wire slides in it).
RodSection<double> rod_section(const GuidewireOptions& options);

/// @param model  in the scene's numbering
/// @throws InputError if the guidewire has fewer than 5 nodes or two in one place
SceneRod make_rod(const SimulationModel& model, const GuidewireOptions& options);

}  // namespace angio::simulation::detail

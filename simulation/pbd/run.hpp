#pragma once

#include <vector>

#include "simulation/pbd/tets.hpp"
#include "simulation/step/status.hpp"

namespace angio::simulation::detail {

/// The reference method between the steps of a run: its contact follows the air mesh, its gas gives
/// the pressure.
class PbdRun {
 public:
  PbdRun(const Scene& scene, const SimulationOptions& options);

  /// Does its contact want the air mesh of each frame?
  [[nodiscard]] bool takes_air() const { return takes_air_; }
  /// Takes the tets of an air mesh that is not empty.
  ///
  /// @param items  viscous items of the last tets
  /// @return those of the new tets
  std::vector<char> follow(const std::vector<Tet>& air, const std::vector<char>& items);
  /// Of its contact, once the air mesh has followed.
  [[nodiscard]] const PbdTets& tets() const { return tets_; }

  /// What a frame reports [Pa]: of its gas, if there is one, else of the step.
  [[nodiscard]] double pressure(const StepStatus& status, const std::vector<Vec3>& x) const;

 private:
  const Scene& scene_;
  const SimulationOptions options_;
  const bool takes_air_, has_gas_;
  PbdGasTets gas_;
  PbdTets tets_;
};

}  // namespace angio::simulation::detail

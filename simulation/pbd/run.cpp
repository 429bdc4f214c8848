#include "simulation/pbd/run.hpp"

#include <utility>

#include "simulation/run/schedule.hpp"

namespace angio::simulation::detail {

PbdRun::PbdRun(const Scene& scene, const SimulationOptions& options)
    : scene_(scene),
      options_(options),
      takes_air_(projects_contact(scene, options)),
      has_gas_(pbd_policy(options).gas) {
  if (has_gas_) gas_ = pbd_gas_tets(scene);
}

std::vector<char> PbdRun::follow(const std::vector<Tet>& air, const std::vector<char>& items) {
  PbdTets now = pbd_tets(scene_, options_, air);
  std::vector<char> kept = kept_items(tets_, items, now);
  tets_ = std::move(now);
  return kept;
}

double PbdRun::pressure(const StepStatus& status, const std::vector<Vec3>& x) const {
  return has_gas_ ? mean_tet_pressure(gas_, status.tet_growth, outside_pressure(options_), x)
                  : status.pressure;
}

}  // namespace angio::simulation::detail

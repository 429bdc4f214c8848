#include "simulation/pbd/policy.hpp"

#include "core/error.hpp"

namespace angio::simulation::detail {

PbdPolicy pbd_policy(const SimulationOptions& options) {
  return {options.contact.model == ContactModel::paper, options.gas_model == GasModel::per_tet};
}

void validate_pbd(const SimulationOptions& options) {
  if (!pbd_policy(options).gas) return;
  if (options.inflation.control != InflationControl::volume)
    throw OptionError(
        "simulation.gas_model is per_tet, and inflation.control is not volume (the paper's gas is "
        "a "
        "command for volumes and knows no pressure). Use inflation.control = volume");
  if (options.guidewire.model == GuidewireModel::rod)
    throw OptionError(
        "simulation.gas_model is per_tet, and guidewire.model is rod (the paper's tetrahedra stand "
        "on a guidewire that does not move). Use guidewire.model = none");
}

std::vector<std::string> pbd_warnings(const SimulationOptions& options) {
  const PbdPolicy policy = pbd_policy(options);
  std::vector<std::string> warnings;
  if (policy.contact)
    warnings.emplace_back(
        "contact.model paper does not converge (its result depends on the number of sweeps): for "
        "comparison only");
  if (policy.gas)
    warnings.emplace_back(
        "simulation.gas_model per_tet sets volumes without a balance of forces (its result depends "
        "on the number of sweeps): for comparison only");
  return warnings;
}

}  // namespace angio::simulation::detail

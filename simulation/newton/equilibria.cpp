#include "simulation/newton/equilibria.hpp"

#include <cmath>

#include "core/error.hpp"
#include "simulation/backends/step_solver.hpp"

namespace angio::simulation::detail {
namespace {

constexpr double kNoLimit = 1e30;  // fits in a float

GasLaw<double> law_of(Load::Kind kind, double value, double outside, double pressure_before) {
  GasLaw<double> law;
  law.limit = law.top = kNoLimit;
  if (kind == Load::Kind::pressure) {
    law.slope_pressure = outside + value;
  } else {
    law.volume = value;
    law.slope_pressure = pressure_before;
  }
  return law;
}

SimulationModel without_wall(SimulationModel model) {
  model.wall = {};
  model.wall_fixed.clear();
  model.wall_abscissa.clear();
  model.wall_group.clear();
  model.air.clear();
  return model;
}

}  // namespace

std::vector<Equilibrium> find_equilibria(const SimulationModel& model,
                                         const SimulationOptions& options,
                                         const std::vector<Load>& loads, double tolerance,
                                         int most_sweeps) {
  options.validate();
  SimulationOptions free = options;
  free.guidewire.model = GuidewireModel::none;
  const Scene scene = make_scene(without_wall(model), free);
  const double outside = outside_pressure(options);
  const auto solver = options.backend == Backend::cuda ? make_cuda_solver(scene, options)
                                                       : make_cpu_solver(scene, options);
  State state = start_state(scene, outside);
  std::vector<Equilibrium> results;
  for (const Load& load : loads) {
    if (!std::isfinite(load.value) || (load.kind == Load::Kind::volume && !(load.value > 0.0)))
      throw OptionError(
          "a load of the balloon is not a pressure or a positive volume (there is no shape for "
          "it)");
    // Volumes are approached in steps of 10 %; a pressure is applied at once.
    const bool by_volume = load.kind == Load::Kind::volume;
    const int steps = by_volume ? 1 + int(std::abs(std::log(load.value / state.volume)) / 0.1) : 1;
    const double from = state.volume;
    Equilibrium result;
    for (int step = 1; step <= steps; ++step) {
      const double value =
          by_volume ? from * std::pow(load.value / from, double(step) / steps) : load.value;
      state = solver->settle(law_of(load.kind, value, outside, state.pressure),
                             step < steps ? 0.01 : tolerance, most_sweeps);
      result.sweeps += state.report.sweeps;
    }
    result.x.resize(std::size_t(scene.bodies.balloon().count));
    for (std::size_t v = 0; v < result.x.size(); ++v)
      result.x[std::size_t(scene.caller_vertex[v])] = state.x[v];
    result.pressure = state.pressure - outside;
    result.volume = state.volume;
    result.residual = state.report.residual;
    result.lag = state.report.lag;
    result.converged = result.lag <= tolerance && result.residual <= tolerance;
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace angio::simulation::detail

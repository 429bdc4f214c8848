#pragma once

#include <utility>
#include <vector>

#include "simulation/backends/step_solver.hpp"
#include "simulation/pbd/run.hpp"
#include "simulation/step/make_views.hpp"

namespace angio::simulation::detail {

/// What the solvers of all backends share: how a run begins and settles, the reference method's
/// tets, and what a frame ends with.
template <class Real>
class SolverBase : public StepSolver {
 public:
  State settle(const GasLaw<double>& law, double tolerance, int most_sweeps) final {
    status_.law = law;
    return take_step(settling_rules(scene_, options_, tolerance, most_sweeps));
  }

  State step(const GasLaw<double>& law, const StepRules& rules) final {
    status_.law = law;
    return take_step(rules);
  }

  // A tet that stays keeps its viscous item.
  void set_air(const std::vector<Tet>& air) final {
    if (!pbd_.takes_air() || air.empty()) return;
    std::vector<char> kept = pbd_.follow(air, viscous_items(pbd_.tets().balloon_corners.size()));
    use_tets(pbd_.tets(), std::move(kept));
  }

 protected:
  SolverBase(const Scene& scene, const SimulationOptions& options)
      : scene_(scene),
        options_(options),
        plasticity_(plastic_flow<Real>(options.wall)),
        start_(local<Real>(scene, scene.start)),
        pbd_(scene, options) {
    status_.pressure = outside_pressure(options);
    status_.volume = balloon_volume(scene, scene.start);
  }

  /// One step under the status' law. @return what it ends with
  virtual State take_step(const StepRules& rules) = 0;
  /// Of the reference method's tets as they were used last.
  virtual std::vector<char> viscous_items(std::size_t count) = 0;
  virtual void use_tets(const PbdTets& tets, std::vector<char> viscous_items) = 0;

  /// @param end  in the computer's memory
  [[nodiscard]] State state_of(const StateView<Real>& end, const StepStatus& status) const {
    State state = make_state(scene_, start_.data(), end, status);
    state.pressure = pbd_.pressure(status, state.x);
    return state;
  }

  const Scene& scene_;
  const SimulationOptions options_;
  const PlasticFlow<Real> plasticity_;
  const std::vector<Vec3T<Real>> start_;
  StepStatus status_;

 private:
  PbdRun pbd_;
};

}  // namespace angio::simulation::detail

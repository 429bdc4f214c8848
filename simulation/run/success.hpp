#pragma once

#include <string>

#include "simulation/backends/step_solver.hpp"
#include "simulation/bodies/scene.hpp"

/// Did a run end right?
namespace angio::simulation::detail {

/// The greatest contact pressure of a patch of the wall: the mean, by present area, over what is
/// connected to a vertex within half the healthy vessel's radius, and over two rings of neighbours
/// where the mesh is coarser. So it does not depend on the mesh: what a single sliver carries is
/// its mesh's, not the balloon's.
struct PatchPressure {
  double pressure = 0.0;  ///< [Pa]
  int vertex = -1;        ///< in its middle, of the wall, in the scene's order
};
/// @param radius  of a patch [mm]
PatchPressure patch_pressure(const Scene& scene, const State& state, double radius);

/// Watches a run's frames for what cannot be a result:
///
///  - balloon and wall cross: deeper than a thousandth of the contact distance, which is the
///    rounding of positions;
///  - a patch of wall carries more than five times the peak pressure: equilibrium with a membrane
///    asks for about the balloon's own, more only at its shoulders;
///  - forces are off by more than 20 % after twenty-four times the sweeps that a frame gets
///  (StepRules);
///  - a number is not finite.
///
/// What is for comparison only (the paper's contact and gas) is not judged.
class SuccessWatch {
 public:
  SuccessWatch(const Scene& scene, const SimulationModel& model, const SimulationOptions& options);

  /// What is judged of a state.
  struct Look {
    bool is_finite = true;
    PatchPressure patch;
  };
  /// From any thread.
  [[nodiscard]] Look look(const State& state) const;
  /// In the order of the frames.
  void judge(const Look& look, const SimulationFrame& frame);
  /// To be called after the last frame. @return empty: the run ended right
  [[nodiscard]] const std::string& failure() const { return failure_; }
  /// The greatest patch pressure over the peak pressure.
  [[nodiscard]] double worst_pressure_ratio() const { return worst_ratio_; }

 private:
  void fail(const SimulationFrame& frame, const std::string& what, const std::string& advice);

  const Scene& scene_;
  const SimulationModel& model_;
  bool is_judged_;
  double peak_pressure_;     ///< [Pa]
  double contact_distance_;  ///< [mm]
  double worst_ratio_ = 0.0;
  std::string failure_;  ///< the first one
};

}  // namespace angio::simulation::detail

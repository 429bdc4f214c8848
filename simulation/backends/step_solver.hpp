#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/tet_mesh.hpp"
#include "simulation/backends/state.hpp"
#include "simulation/run/control.hpp"

namespace angio::simulation::detail {

// double_: without its underscore it is a keyword.
enum class Precision { automatic, single, double_ };  // NOLINT(readability-identifier-naming)

/// Single, unless the rounding of single positions would outweigh the force balance: the noise of
/// an edge's strain, the spacing of floats across the scene over the edge, against the strain that
/// the peak pressure asks for, must stay below half the residual that ends the sweeps.
Precision precision_for(const Scene& scene, const SimulationOptions& options);

/// Takes the steps of a run on one backend: program.hpp. It is made from the model (Scene), is
/// driven by a Control and gives States.
class StepSolver {
 public:
  virtual ~StepSolver() = default;

  /// Goes through the inflator's frames, from the start state (frame 0) on; `on_state` gets each
  /// in order. A backend may be some frames ahead of it.
  virtual void run(const Control& control,
                   const std::function<void(int frame, State&& state)>& on_state) = 0;

  /// The equilibrium under a law, without a wall, found from the last one.
  ///
  /// @param tolerance  of the remaining distance, as a share of the radius
  virtual State settle(const GasLaw<double>& law, double tolerance, int most_sweeps) = 0;

  /// One step with inertia under a law, from where the last one has ended.
  virtual State step(const GasLaw<double>& law, const StepRules& rules) = 0;

  /// Puts the vertices elsewhere, in the scene's numbering [mm]; those that move are at rest there.
  /// On the CPU only.
  virtual void put(const std::vector<Vec3>&) {}

  [[nodiscard]] virtual std::string device() const = 0;

  /// The air mesh as it is after a frame, right-handed, for the reference method's contact in the
  /// next one.
  virtual void set_air(const std::vector<Tet>&) {}

  /// A hand on the vertices, for tests: changes the velocities [mm/s] before each step, given the
  /// positions [mm]. On the CPU only.
  using Push = std::function<void(int frame, const std::vector<Vec3>& x, std::vector<Vec3>& v)>;
  virtual void set_push(const Push&) {}
};

/// @param threads  0: as many as pay
std::unique_ptr<StepSolver> make_cpu_solver(const Scene& scene, const SimulationOptions& options,
                                            Precision precision = Precision::automatic,
                                            int threads = 0);

/// Is there a GPU that this program can use?
bool has_cuda_device();
/// Empty if there is none that works.
std::string cuda_device_name();

/// Has the GPU begin what it does once a program, where there is one.
void wake_cuda_device();

/// How a balloon alone is spread over a GPU: one block, or all of it, as anything else is.
enum class Spread { automatic, block, grid };

/// @throws Error (unavailable) if the program was built without CUDA or there is no usable GPU
std::unique_ptr<StepSolver> make_cuda_solver(const Scene& scene, const SimulationOptions& options,
                                             Precision precision = Precision::automatic,
                                             Spread spread = Spread::automatic);

}  // namespace angio::simulation::detail

#include "core/error.hpp"
#include "simulation/backends/step_solver.hpp"

#ifndef ANGIO_HAS_CUDA
namespace angio::simulation::detail {

bool has_cuda_device() { return false; }
std::string cuda_device_name() { return {}; }
void wake_cuda_device() {}

std::unique_ptr<StepSolver> make_cuda_solver(const Scene&, const SimulationOptions&, Precision,
                                             Spread) {
  throw Error(ExitCode::unavailable,
              "the CUDA backend was asked for, but this program was not built with CUDA. Use "
              "--backend cpu");
}

}  // namespace angio::simulation::detail
#endif

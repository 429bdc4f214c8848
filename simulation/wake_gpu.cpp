#include "simulation/wake_gpu.hpp"

#include <system_error>

#include "simulation/backends/step_solver.hpp"

namespace angio::simulation {

std::future<void> wake_gpu(Backend backend) {
  if (backend == Backend::cpu) return {};
  try {
    return std::async(std::launch::async, detail::wake_cuda_device);
  } catch (const std::system_error&) {  // no thread can be had: the solver wakes it
    return {};
  }
}

}  // namespace angio::simulation

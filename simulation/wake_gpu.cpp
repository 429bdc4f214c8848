#include "simulation/wake_gpu.hpp"

#include "simulation/backends/step_solver.hpp"

namespace angio::simulation {

std::future<void> wake_gpu(Backend backend) {
  if (backend == Backend::cpu) return {};
  return std::async(std::launch::async, detail::wake_cuda_device);
}

}  // namespace angio::simulation

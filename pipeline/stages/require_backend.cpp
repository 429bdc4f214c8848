#include "pipeline/stages/require_backend.hpp"

#include "core/error.hpp"
#include "simulation/simulation.hpp"

namespace angio::pipeline {

void require_backend(Backend backend) {
  if (backend != Backend::cuda) return;
  const simulation::CudaSupport cuda = simulation::cuda_support();
  if (!cuda.built)
    throw Error(ExitCode::unavailable,
                "--backend cuda is not available here (this program was built without CUDA). Use "
                "--backend cpu or auto");
  if (cuda.device.empty())
    throw Error(ExitCode::unavailable,
                "--backend cuda is not available here (no NVIDIA GPU works; `angio doctor` says "
                "what there is). Use --backend cpu or auto");
}

}  // namespace angio::pipeline

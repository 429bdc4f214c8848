#include "core/error.hpp"
#include "reconstruction/detail/volume_task.hpp"

#ifndef ANGIO_HAS_CUDA
namespace angio::reconstruction::detail {

std::string gpu_name() { return {}; }

std::string require_gpu() {
  throw Error(ExitCode::unavailable,
              "the CUDA backend was asked for, but this program was not built with CUDA. Use "
              "--backend cpu");
}

ProjectedBack project_back_on_gpu(const VolumeTask&, const Progress&) {
  require_gpu();
  return {};
}

}  // namespace angio::reconstruction::detail
#endif

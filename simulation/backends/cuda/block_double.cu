#include "simulation/backends/cuda/kernels.cuh"

namespace angio::simulation::detail {

template const void* block_kernel_pointer<double>();

}  // namespace angio::simulation::detail

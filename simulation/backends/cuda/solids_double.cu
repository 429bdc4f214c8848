#include "simulation/backends/cuda/kernels.cuh"

namespace angio::simulation::detail {

template const void* grid_kernel_pointer<double, Extent::solids>();

}  // namespace angio::simulation::detail

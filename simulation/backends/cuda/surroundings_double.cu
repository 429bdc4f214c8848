#include "simulation/backends/cuda/kernels.cuh"

namespace angio::simulation::detail {

template const void* grid_kernel_pointer<double, Extent::surroundings>();

}  // namespace angio::simulation::detail

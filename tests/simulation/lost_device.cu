#include "tests/simulation/lost_device.hpp"

namespace angio::simulation::testing {
namespace {

__global__ void trap() { __trap(); }

}  // namespace

void lose_device() {
  trap<<<1, 1>>>();
  cudaDeviceSynchronize();
}

}  // namespace angio::simulation::testing

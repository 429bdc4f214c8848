#include "testing/cuda/lost_device.hpp"

namespace angio::testing {
namespace {

__global__ void trap() { __trap(); }

}  // namespace

void lose_device() {
  trap<<<1, 1>>>();
  cudaDeviceSynchronize();
}

}  // namespace angio::testing

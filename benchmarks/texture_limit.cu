#include <cuda_runtime_api.h>

#include <algorithm>
#include <array>
#include <vector>

#include "benchmarks/texture_limit.hpp"

namespace angio::benchmarks {
namespace {

constexpr int kSide = 64;
constexpr int kThreads = 256;
constexpr int kRounds = 256;
constexpr int kAtOnce = 16;

__global__ void fetch(cudaTextureObject_t image, float* sums) {
  const float x = float(threadIdx.x % 8) + 0.7F, y = float(threadIdx.x / 8) + 0.3F;
  float sum[kAtOnce] = {};
  for (int round = 0; round < kRounds; ++round)
    for (int n = 0; n < kAtOnce; ++n)
      sum[n] += tex2D<float>(image, x + float(n), y + float(round % 16));
  float all = 0.0F;
  for (int n = 0; n < kAtOnce; ++n) all += sum[n];
  sums[blockIdx.x * blockDim.x + threadIdx.x] = all;
}

}  // namespace

double texture_fetches_per_second() {
  cudaDeviceProp properties;
  if (cudaGetDeviceProperties(&properties, 0) != cudaSuccess) return 0.0;
  const cudaChannelFormatDesc format = cudaCreateChannelDesc<float>();
  cudaArray_t array = nullptr;
  cudaMallocArray(&array, &format, kSide, kSide);
  const std::vector<float> values(kSide * kSide, 1.0F);
  cudaMemcpy2DToArray(array, 0, 0, values.data(), kSide * sizeof(float), kSide * sizeof(float),
                      kSide, cudaMemcpyHostToDevice);
  cudaResourceDesc resource{};
  resource.resType = cudaResourceTypeArray;
  resource.res.array.array = array;
  cudaTextureDesc look{};
  look.filterMode = cudaFilterModeLinear;
  cudaTextureObject_t image = 0;
  cudaCreateTextureObject(&image, &resource, &look, nullptr);
  const int blocks = 64 * properties.multiProcessorCount;
  float* sums = nullptr;
  cudaMalloc(&sums, std::size_t(blocks) * kThreads * sizeof(float));
  cudaEvent_t first, last;
  cudaEventCreate(&first);
  cudaEventCreate(&last);
  fetch<<<blocks, kThreads>>>(image, sums);
  std::array<float, 5> milliseconds{};
  for (float& ms : milliseconds) {
    cudaEventRecord(first);
    fetch<<<blocks, kThreads>>>(image, sums);
    cudaEventRecord(last);
    cudaEventSynchronize(last);
    cudaEventElapsedTime(&ms, first, last);
  }
  const bool failed = cudaGetLastError() != cudaSuccess;
  cudaEventDestroy(first);
  cudaEventDestroy(last);
  cudaFree(sums);
  cudaDestroyTextureObject(image);
  cudaFreeArray(array);
  std::sort(milliseconds.begin(), milliseconds.end());
  return failed ? 0.0 : double(blocks) * kThreads * kRounds * kAtOnce / (milliseconds[2] * 1e-3);
}

}  // namespace angio::benchmarks

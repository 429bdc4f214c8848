#include <cub/device/device_scan.cuh>

#include "simulation/backends/cuda_search.hpp"

namespace angio::simulation::detail {
namespace {

constexpr int kThreads = 128;

template <class Loop, class Real>
__global__ void loop_kernel(const __grid_constant__ CandidateSearch<Real> search, int count) {
  const int i = int(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < count) Loop::run(search, i);
}

/// The loops of search_candidates as kernels of a stream.
struct CudaLoops {
  cudaStream_t stream;
  void* scan_memory;
  std::size_t scan_size;
  cudaError_t error = cudaSuccess;

  void keep(cudaError_t result) { error = error == cudaSuccess ? result : error; }

  template <class Value>
  void clear(Value* values, int count) {
    keep(cudaMemsetAsync(values, 0, std::size_t(count) * sizeof(Value), stream));
  }
  template <class Loop, class Real>
  void for_each(int count, const CandidateSearch<Real>& search) {
    if (count == 0) return;
    const int blocks = (count + kThreads - 1) / kThreads;
    loop_kernel<Loop><<<blocks, kThreads, 0, stream>>>(search, count);
    keep(cudaGetLastError());
  }
  void scan(const int* values, int* sums, int count) {
    keep(cub::DeviceScan::ExclusiveSum(scan_memory, scan_size, values, sums, count, stream));
  }
};

}  // namespace

std::size_t scan_bytes(int count) {
  std::size_t bytes = 0;
  cub::DeviceScan::ExclusiveSum(nullptr, bytes, static_cast<const int*>(nullptr),
                                static_cast<int*>(nullptr), count);
  return bytes;
}

template <class Real>
cudaError_t launch_search(const CandidateSearch<Real>& search, void* scan_memory,
                          cudaStream_t stream) {
  CudaLoops loops{stream, scan_memory, scan_bytes(search.vertex_count + 1)};
  search_candidates(loops, search);
  return loops.error;
}

template cudaError_t launch_search(const CandidateSearch<float>&, void*, cudaStream_t);
template cudaError_t launch_search(const CandidateSearch<double>&, void*, cudaStream_t);

}  // namespace angio::simulation::detail

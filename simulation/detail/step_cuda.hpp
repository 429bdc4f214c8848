#pragma once

#include <cuda_runtime_api.h>

#include "simulation/detail/schedule.hpp"
#include "simulation/detail/step_program.hpp"

/// Launching step_program.hpp on a GPU. Only step_cuda.cu and cuda_solver.cpp include this.
namespace angio::simulation::detail {

/// Some frames of a step, or parts of one, in one launch. Pointers are the device's.
template <class Real>
struct CudaProgram {
  StepView<Real> view;
  StepRules rules;
  PlasticFlow<Real> plasticity;
  int parts = kBegin | kSweeps | kEnd;
  int first_frame = 0, frame_count = 1;
  Inflator* inflator = nullptr;        ///< nullptr: the law is in the status
  StepStatus* status = nullptr;        ///< before, and after the last frame
  StepStatus* frame_status = nullptr;  ///< after each, shape [frame_count]
  Vec3T<Real>* frame_x = nullptr;      ///< positions after each, shape [frame_count, vertex]
  void* sums = nullptr;                ///< kCudaSumBytes for the sums of a grid
};

inline constexpr std::size_t kCudaSumBytes = 2 * 1024 * 4 * sizeof(double);

/// How a program is spread over the GPU: one block whose positions lie in its shared memory, with
/// barriers of a fifth of a microsecond; or all of the GPU, with barriers of more than one.
struct CudaShape {
  bool grid = false;
  int blocks = 1, threads = 0;
  std::size_t shared_bytes = 0;
};

/// The shape that suits a scene, or the one that is asked for.
template <class Real>
CudaShape cuda_shape(const StepView<Real>& view, int device);
template <class Real>
CudaShape cuda_shape(const StepView<Real>& view, int device, bool grid);

template <class Real>
cudaError_t launch(const CudaProgram<Real>& program, const CudaShape& shape, cudaStream_t stream);

}  // namespace angio::simulation::detail

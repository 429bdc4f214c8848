#pragma once

#include <cuda_runtime_api.h>

#include "simulation/run/schedule.hpp"
#include "simulation/step/program.hpp"
#include "simulation/step/state_view.hpp"

/// Launching program.hpp on a GPU. Only cuda_launch.cu and cuda_solver.cpp include this.
namespace angio::simulation::detail {

/// What a launch leaves of its frames. Each array of `state` holds one frame after the other; its
/// count is that of one frame.
template <class Real>
struct CudaFrames {
  StateView<Real> state;
  StepStatus* status = nullptr;  ///< [frame + 1], at last that which the launch ends with
};

/// Some frames in one launch, from where the last launch has ended: it may have halted within a
/// frame for want of candidates. Pointers are the device's.
template <class Real>
struct CudaProgram {
  StepView<Real> view;
  StepRules rules;
  PlasticFlow<Real> plasticity;
  int frame_count = 1;           ///< at most
  int last_frame = 1;            ///< of the run
  Inflator* inflator = nullptr;  ///< nullptr: the law is in the status
  StepStatus* status = nullptr;  ///< before, and at the end
  CudaFrames<Real> frames;       ///< of this launch
  void* sums = nullptr;          ///< kCudaSumBytes for the sums of a grid
};

inline constexpr std::size_t kCudaSumBytes = 2 * 1024 * 4 * sizeof(double);

/// How a program is spread over the GPU: a balloon alone over one block, whose positions lie in its
/// shared memory, with barriers of a fifth of a microsecond; or over all of the GPU, with barriers
/// of more than one.
struct CudaShape {
  bool grid = false;
  int blocks = 1, threads = 0;
  std::size_t shared_bytes = 0;
};

/// The shape that suits a scene, or the one that is asked for, which counts for a balloon alone.
template <class Real>
CudaShape cuda_shape(const StepView<Real>& view, int device);
template <class Real>
CudaShape cuda_shape(const StepView<Real>& view, int device, bool grid);

template <class Real>
cudaError_t launch(const CudaProgram<Real>& program, const CudaShape& shape, cudaStream_t stream);

}  // namespace angio::simulation::detail

#pragma once

#include <cuda_runtime_api.h>

#include "reconstruction/detail/back_projection.hpp"
#include "reconstruction/detail/line_integrals.hpp"
#include "reconstruction/detail/plane_samples.hpp"
#include "reconstruction/detail/row_filter.hpp"

/// What the GPU is given to do. Pointers are the device's. Only volume_on_gpu.cpp and kernels.cu
/// include this.
namespace angio::reconstruction::detail {

inline constexpr int kMostFrames = 32;  ///< that voxels are made of at a time

/// Pictures to line integrals, with what a shutter covers filled in.
struct IntegralsTask {
  const float* pictures = nullptr;  ///< shape [frame_count, rows, columns]
  const float* masks = nullptr;     ///< the same, or null
  float* integrals = nullptr;       ///< the same
  int frame_count = 0, columns = 0, rows = 0;
  OpenField open_field;
  BeamRule rule;
};
cudaError_t launch_integrals(const IntegralsTask& task, cudaStream_t stream);

/// A frame's place in its picture and its plane.
struct FrameOnGpu {
  PlaneMap map;
  PlaneFrame place;
  float arc = 0.0F;  ///< that it stands for [radians]
};

/// Line integrals onto planes, weighted and filtered.
struct FilterTask {
  const float* integrals = nullptr;    ///< shape [frame_count, rows, columns]
  const FrameOnGpu* frames = nullptr;  ///< shape [frame_count]
  const float* weights = nullptr;      ///< ray_weights(), shape [frame_count, u_count]
  int frame_count = 0, first_layer = 0, v_count = 0;
  RowFilter filter;                    ///< its columns are u_count
  cudaSurfaceObject_t filtered = 0;    ///< layers of u_count x v_count
  unsigned* truncated_rows = nullptr;  ///< is added to
};
/// @return cudaErrorInvalidValue if the rows are longer than the GPU can hold together
cudaError_t launch_filter(const FilterTask& task, cudaStream_t stream);

/// Filtered frames to voxels.
struct VoxelTask {
  cudaTextureObject_t filtered = 0;
  int u_count = 0, frame_count = 0;
  ColumnGrid grid;
  float* values = nullptr;  ///< is added to; shape [k_count, j_count, i_count]
  PlaneFrame frames[kMostFrames];
};
cudaError_t launch_voxels(const VoxelTask& task, cudaStream_t stream);

}  // namespace angio::reconstruction::detail

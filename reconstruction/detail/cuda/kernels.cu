#include "reconstruction/detail/cuda/kernels.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr int kIntegralThreads = 256;
constexpr int kFilterThreads = 512;

/// The threads of a block.
struct BlockTeam {
  template <class Each>
  __device__ void each(int count, const Each& body) const {
    for (int i = int(threadIdx.x); i < count; i += int(blockDim.x)) body(i);
    __syncthreads();
  }
};

__global__ void integrals_kernel(IntegralsTask task) {
  const int column = int(blockIdx.x * blockDim.x + threadIdx.x), row = int(blockIdx.y);
  if (column >= task.columns) return;
  const OpenField& open = task.open_field;
  const int from_row = min(max(row, open.first_row), open.last_row);
  const int from_column = min(max(column, open.first_column), open.last_column);
  const std::size_t width = std::size_t(task.columns);
  const std::size_t frame = std::size_t(blockIdx.z) * width * std::size_t(task.rows);
  const std::size_t from = frame + std::size_t(from_row) * width + std::size_t(from_column);
  task.integrals[frame + std::size_t(row) * width + std::size_t(column)] =
      line_integral(task.pictures[from], task.masks ? task.masks + from : nullptr, task.rule);
}

__global__ void __launch_bounds__(kFilterThreads) filter_kernel(FilterTask task) {
  extern __shared__ Complex values[];
  __shared__ RowPairEnds ends;
  const int j = 2 * int(blockIdx.x), f = int(blockIdx.y), layer = task.first_layer + f;
  const bool is_pair = j + 1 < task.v_count;
  const FrameOnGpu& frame = task.frames[f];
  const float* picture = task.integrals + std::size_t(f) * std::size_t(frame.map.columns) *
                                              std::size_t(frame.map.rows);
  const float* weights = task.weights + std::size_t(f) * std::size_t(task.filter.columns);
  const float radius = frame.place.radius, spacing = float(task.filter.spacing_mm);
  const float along = frame.place.first_v + float(j) * spacing - frame.place.height;
  filter_row_pair(
      BlockTeam{}, task.filter,
      [&](int i) {
        return Complex{sample_picture(picture, frame.map, i, j),
                       is_pair ? sample_picture(picture, frame.map, i, j + 1) : 0.0F};
      },
      [&](int i) {
        const float across = frame.place.first_u + float(i) * spacing;
        return Complex{weights[i] * slant_weight(radius, across, along),
                       weights[i] * slant_weight(radius, across, along + spacing)};
      },
      [&](int i, const Complex& pair) {
        surf2DLayeredwrite(frame.arc * pair.re, task.filtered, i * int(sizeof(float)), j, layer);
        if (is_pair)
          surf2DLayeredwrite(frame.arc * pair.im, task.filtered, i * int(sizeof(float)), j + 1,
                             layer);
      },
      values, ends);
  if (threadIdx.x == 0) atomicAdd(task.truncated_rows, unsigned(ends.truncated_rows()));
}

// A block has 16 x 16 lines of voxels, a warp 8 x 4 of them, four threads that follow each other
// 2 x 2: so their rays lie close together on every frame, whichever way it looks, and they write
// whole sectors of the volume. A thread has some voxels of its line.
constexpr int kTile = 16;
constexpr int kStretch = 16;

__global__ void __launch_bounds__(kTile* kTile)
    voxels_kernel(const __grid_constant__ VoxelTask task) {
  const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32, four = lane / 4;
  const int i = int(blockIdx.x) * kTile + warp % 2 * 8 + four % 4 * 2 + lane % 2;
  const int j = int(blockIdx.y) * kTile + warp / 2 * 4 + four / 4 * 2 + lane / 2 % 2;
  const int first_k = int(blockIdx.z) * kStretch;
  const ColumnGrid& grid = task.grid;
  if (i >= grid.i_count || j >= grid.j_count) return;
  const Stretch at{grid.first_x + float(i) * grid.voxel, grid.first_y + float(j) * grid.voxel,
                   grid.first_z + float(first_k) * grid.voxel, grid.voxel};
  if (at.x * at.x + at.y * at.y > grid.field_radius * grid.field_radius) return;
  float sums[kStretch] = {};
  for (int f = 0; f < task.frame_count; ++f)
    add_frame(
        task.frames[f], task.u_count, at,
        [&](float u, float v) { return tex2DLayered<float>(task.filtered, u + 0.5F, v + 0.5F, f); },
        sums);
  const std::size_t slice = std::size_t(grid.i_count) * std::size_t(grid.j_count);
  float* value = task.values + std::size_t(first_k) * slice +
                 std::size_t(j) * std::size_t(grid.i_count) + std::size_t(i);
  for (int n = 0; n < kStretch; ++n)
    if (first_k + n < grid.k_count) value[std::size_t(n) * slice] += sums[n];
}

unsigned blocks(int count, int each) { return unsigned((count + each - 1) / each); }

}  // namespace

cudaError_t launch_integrals(const IntegralsTask& task, cudaStream_t stream) {
  const dim3 grid(blocks(task.columns, kIntegralThreads), unsigned(task.rows),
                  unsigned(task.frame_count));
  integrals_kernel<<<grid, kIntegralThreads, 0, stream>>>(task);
  return cudaGetLastError();
}

cudaError_t launch_filter(const FilterTask& task, cudaStream_t stream) {
  const std::size_t shared = std::size_t(task.filter.length) * sizeof(Complex);
  const cudaError_t error =
      cudaFuncSetAttribute(filter_kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, int(shared));
  if (error != cudaSuccess) return error;
  const dim3 grid(blocks(task.v_count, 2), unsigned(task.frame_count));
  filter_kernel<<<grid, kFilterThreads, shared, stream>>>(task);
  return cudaGetLastError();
}

cudaError_t launch_voxels(const VoxelTask& task, cudaStream_t stream) {
  const dim3 grid(blocks(task.grid.i_count, kTile), blocks(task.grid.j_count, kTile),
                  blocks(task.grid.k_count, kStretch));
  voxels_kernel<<<grid, kTile * kTile, 0, stream>>>(task);
  return cudaGetLastError();
}

}  // namespace angio::reconstruction::detail

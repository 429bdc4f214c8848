#include <algorithm>

#include "simulation/backends/cuda/teams.cuh"

namespace angio::simulation::detail {
namespace {

/// A balloon alone has its own kernels, which need no registers for contact; a layered wall and
/// what the paper projects have theirs, which need many.
template <class Real>
Extent extent_of(const StepView<Real>& view) {
  if (view.layered.columns.levels > 0 || view.pbd.is_on()) return Extent::solids;
  return view.bodies.wall().count == 0 && view.guidewire.shape.count == 0 &&
                 !(view.contact.law.self_distance > Real(0))
             ? Extent::alone
             : Extent::surroundings;
}

template <class Real>
const void* kernel_of(const StepView<Real>& view, bool grid) {
  if (!grid) return block_kernel_pointer<Real>();
  switch (extent_of(view)) {
    case Extent::alone:
      return grid_kernel_pointer<Real, Extent::alone>();
    case Extent::surroundings:
      return grid_kernel_pointer<Real, Extent::surroundings>();
    default:
      return grid_kernel_pointer<Real, Extent::solids>();
  }
}

/// Threads that a colour keeps busy.
template <class Real>
int threads_at_work(const StepView<Real>& view) {
  using Alone = GridTeam<Real, Extent::alone>;
  using Beside = GridTeam<Real, Extent::surroundings>;
  using Solids = GridTeam<Real, Extent::solids>;
  const int balloon = view.bodies.balloon().count / std::max(1, view.balloon.mesh.colors),
            wall = view.bodies.wall().count / std::max(1, view.wall.mesh.colors);
  switch (extent_of(view)) {
    case Extent::alone:
      return balloon * Alone::kBalloonLanes;
    case Extent::surroundings:
      return std::max(balloon * Beside::kBalloonLanes, wall * Beside::kVertexLanes);
    default:
      return std::max(balloon * Solids::kBalloonLanes, wall * Solids::kVertexLanes);
  }
}

}  // namespace

template <class Real>
CudaShape cuda_shape(const StepView<Real>& view, int device, bool grid) {
  CudaShape shape;
  shape.grid = grid || extent_of(view) != Extent::alone;
  if (!shape.grid) {
    shape.threads = kBlockThreads;
    shape.shared_bytes = block_bytes(view);
    return shape;
  }
  int processors = 0, resident = 0;
  cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device);
  cudaOccupancyMaxActiveBlocksPerMultiprocessor(&resident, kernel_of(view, true), kGridThreads, 0);
  // No more blocks than a colour has work for: they would only lengthen the barrier. Where pairs
  // are searched and renewed, of all vertices at once, every processor has work.
  const int most = std::clamp(processors * resident, 1, 1024);
  const int least = extent_of(view) == Extent::surroundings ? std::min(processors, most) : 1;
  shape.threads = kGridThreads;
  shape.blocks = std::clamp((threads_at_work(view) + kGridThreads - 1) / kGridThreads, least, most);
  return shape;
}

template <class Real>
CudaShape cuda_shape(const StepView<Real>& view, int device) {
  constexpr int kMostForOneBlock = 800;  // vertices: more are faster on the whole GPU
  int shared = 0;
  cudaDeviceGetAttribute(&shared, cudaDevAttrMaxSharedMemoryPerBlockOptin, device);
  const bool fits = block_bytes(view) + sizeof(BlockShared) <= std::size_t(shared);
  return cuda_shape(view, device, !fits || view.bodies.balloon().count > kMostForOneBlock);
}

template <class Real>
cudaError_t launch(const CudaProgram<Real>& program, const CudaShape& shape, cudaStream_t stream) {
  void* arguments[] = {const_cast<CudaProgram<Real>*>(&program)};
  const void* kernel = kernel_of(program.view, shape.grid);
  if (shape.grid)
    return cudaLaunchCooperativeKernel(kernel, dim3(unsigned(shape.blocks)),
                                       dim3(unsigned(shape.threads)), arguments, 0, stream);
  const cudaError_t error = cudaFuncSetAttribute(
      kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, int(shape.shared_bytes));
  if (error != cudaSuccess) return error;
  return cudaLaunchKernel(kernel, dim3(1), dim3(unsigned(shape.threads)), arguments,
                          shape.shared_bytes, stream);
}

template CudaShape cuda_shape(const StepView<float>&, int);
template CudaShape cuda_shape(const StepView<double>&, int);
template CudaShape cuda_shape(const StepView<float>&, int, bool);
template CudaShape cuda_shape(const StepView<double>&, int, bool);
template cudaError_t launch(const CudaProgram<float>&, const CudaShape&, cudaStream_t);
template cudaError_t launch(const CudaProgram<double>&, const CudaShape&, cudaStream_t);

}  // namespace angio::simulation::detail

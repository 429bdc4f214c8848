#include <cooperative_groups.h>

#include <algorithm>

#include "simulation/detail/step_cuda.hpp"

namespace angio::simulation::detail {
namespace {

// Of the one block: four threads for each of the 140 vertices in a colour of a usual balloon, and
// 112 registers for each thread.
constexpr int kBlockThreads = 576;
constexpr int kGridThreads = 256;
constexpr int kWarp = 32;

/// Consecutive threads of a warp that share an index.
template <int L>
struct WarpLanes {
  unsigned mask;
  __device__ WarpLanes()
      : mask(L == kWarp ? ~0U : ((1U << (L % kWarp)) - 1U) << (threadIdx.x % kWarp / L * L)) {}
  __device__ int rank() const { return int(threadIdx.x) % L; }
  static constexpr __device__ int size() { return L; }
  __device__ void sync() const { __syncwarp(mask); }
  __device__ int before(bool yes) const {
    return __popc(__ballot_sync(mask, yes) & mask & ((1U << (threadIdx.x % kWarp)) - 1U));
  }
  // Pairs are added the same way in both, so every lane gets the same bits.
  template <class Value>
  __device__ Value sum(Value value) const {
    for (int step = L / 2; step > 0; step /= 2) value += __shfl_xor_sync(mask, value, step);
    return value;
  }
};

template <class Real>
struct alignas(4 * sizeof(Real)) Quad {
  Real v[4];
};

/// What the threads of a block share.
struct BlockShared {
  Quad<double> quads[2][kWarp];
};

struct Plus {
  template <class Real>
  __device__ Real operator()(Real a, Real b) const {
    return a + b;
  }
};

struct Most {
  template <class Real>
  __device__ Real operator()(Real a, Real b) const {
    return a > b ? a : b;
  }
};

/// The sum (or the like, from 0) over a block's threads, the same bits for each of them; `turn`
/// alternates, so that no thread writes the next sum's parts while another still reads this one's.
template <class Combine, int N, class Real>
__device__ void block_sum(Real (&value)[N], BlockShared& shared, int& turn) {
  const Combine combine;
  Quad<Real>* quads = reinterpret_cast<Quad<Real>*>(shared.quads[turn]);
  turn = 1 - turn;
  for (int n = 0; n < N; ++n)
    for (int step = kWarp / 2; step > 0; step /= 2)
      value[n] = combine(value[n], __shfl_xor_sync(~0U, value[n], step));
  if (threadIdx.x % kWarp == 0) {
    Quad<Real> quad{};
    for (int n = 0; n < N; ++n) quad.v[n] = value[n];
    quads[threadIdx.x / kWarp] = quad;
  }
  __syncthreads();
  for (int n = 0; n < N; ++n) value[n] = Real(0);
  for (int warp = 0; warp < int(blockDim.x) / kWarp; ++warp) {
    const Quad<Real> quad = quads[warp];
    for (int n = 0; n < N; ++n) value[n] = combine(value[n], quad.v[n]);
  }
}

// Runs body(i, lanes, part) over the indices of this thread among `threads`.
template <int L, class Real, class Body>
__device__ void add_parts(int count, int thread, int threads, const Body& body, Real* part, int n) {
  const WarpLanes<L> lanes;
  for (int i = thread / L; i < count; i += threads / L) body(i, lanes, part);
  if (lanes.rank() > 0)
    for (int k = 0; k < n; ++k) part[k] = Real(0);
}

struct DeviceClock {
  static __device__ double now() {
    unsigned long long t;
    asm volatile("mov.u64 %0, %globaltimer;" : "=l"(t));
    return 1e-9 * double(t);
  }
};

template <class Real>
class BlockTeam : public DeviceClock {
 public:
  static constexpr bool kSurroundings = false, kSolids = false, kIsSmall = false;
  static constexpr int kBalloonLanes = 4, kVertexLanes = 4, kClusterLanes = 32;

  __device__ explicit BlockTeam(BlockShared& shared) : shared_(shared) {}
  __device__ bool leader() const { return threadIdx.x == 0; }
  __device__ void barrier() const { __syncthreads(); }

  template <int L, class Body>
  __device__ void for_each(int count, const Body& body) const {
    const WarpLanes<L> lanes;
    for (int i = int(threadIdx.x) / L; i < count; i += int(blockDim.x) / L) body(i, lanes);
  }
  template <int L, int N, class Body>
  __device__ void sum(int count, const Body& body, double (&total)[N]) {
    add_up<Plus, L, N, double>(count, body, total);
  }
  template <int L, int N, class Body>
  __device__ void quick_sum(int count, const Body& body, double (&total)[N]) {
    add_up<Plus, L, N, Real>(count, body, total);
  }
  template <int N, class Body>
  __device__ void most(int count, const Body& body, double (&total)[N]) {
    add_up<Most, 1, N, Real>(count, body, total);
  }

 private:
  template <class Combine, int L, int N, class Part, class Body>
  __device__ void add_up(int count, const Body& body, double (&total)[N]) {
    Part part[N] = {};
    add_parts<L>(count, int(threadIdx.x), int(blockDim.x), body, part, N);
    block_sum<Combine>(part, shared_, turn_);
    for (int n = 0; n < N; ++n) total[n] = double(part[n]);
  }

  BlockShared& shared_;
  int turn_ = 0;
};

/// What a grid's program is compiled for: each costs registers.
enum class Extent { alone, surroundings, solids };

template <class Real, Extent extent>
class GridTeam : public DeviceClock {
 public:
  static constexpr bool kSurroundings = extent != Extent::alone, kSolids = extent == Extent::solids,
                        kIsSmall = false;
  static constexpr int kBalloonLanes = kSurroundings ? 32 : 4, kVertexLanes = kSolids ? 16 : 4,
                       kClusterLanes = 32;

  __device__ GridTeam(BlockShared& shared, void* sums)
      : shared_(shared), sums_(sums), grid_(cooperative_groups::this_grid()) {}
  __device__ bool leader() const { return rank() == 0; }
  __device__ void barrier() const { grid_.sync(); }

  template <int L, class Body>
  __device__ void for_each(int count, const Body& body) const {
    const WarpLanes<L> lanes;
    for (int i = rank() / L; i < count; i += size() / L) body(i, lanes);
  }
  template <int L, int N, class Body>
  __device__ void sum(int count, const Body& body, double (&total)[N]) {
    add_up<Plus, L, N, double>(count, body, total);
  }
  template <int L, int N, class Body>
  __device__ void quick_sum(int count, const Body& body, double (&total)[N]) {
    add_up<Plus, L, N, Real>(count, body, total);
  }
  template <int N, class Body>
  __device__ void most(int count, const Body& body, double (&total)[N]) {
    add_up<Most, 1, N, Real>(count, body, total);
  }

 private:
  static constexpr int kMostBlocks = 1024;

  __device__ int rank() const { return int(blockIdx.x * blockDim.x + threadIdx.x); }
  __device__ int size() const { return int(gridDim.x * blockDim.x); }

  template <class Combine, int L, int N, class Part, class Body>
  __device__ void add_up(int count, const Body& body, double (&total)[N]) {
    Part part[N] = {};
    add_parts<L>(count, rank(), size(), body, part, N);
    block_sum<Combine>(part, shared_, turn_);
    const Combine combine;
    Quad<Part>* quads = static_cast<Quad<Part>*>(sums_) + grid_turn_ * kMostBlocks;
    grid_turn_ = 1 - grid_turn_;
    if (threadIdx.x == 0) {
      Quad<Part> quad{};
      for (int n = 0; n < N; ++n) quad.v[n] = part[n];
      quads[blockIdx.x] = quad;
    }
    grid_.sync();
    for (int n = 0; n < N; ++n) part[n] = Part(0);
    for (int b = int(threadIdx.x); b < int(gridDim.x); b += int(blockDim.x)) {
      const Quad<Part> quad = quads[b];
      for (int n = 0; n < N; ++n) part[n] = combine(part[n], quad.v[n]);
    }
    block_sum<Combine>(part, shared_, turn_);
    for (int n = 0; n < N; ++n) total[n] = double(part[n]);
  }

  BlockShared& shared_;
  void* sums_;
  cooperative_groups::grid_group grid_;
  int turn_ = 0, grid_turn_ = 0;
};

// Copies into place k of an array of frames.
template <class Team, class Value>
__device__ void copy_to(Team& team, Value* to, const Value* from, int count, int k) {
  team.template for_each<1>(
      count, [&](int i, const auto&) { to[std::ptrdiff_t(k) * count + i] = from[i]; });
}

// Puts positions and status into place k of the launch's frames.
template <class Real, class Team>
__device__ void keep_end(Team& team, const StepView<Real>& view, const StepStatus& status,
                         const CudaFrames<Real>& frames, int k) {
  copy_to(team, frames.x, view.x, view.vertex_count, k);
  if (team.leader()) frames.status[k] = status;
}

// The same with all that a frame reports.
template <class Real, class Team>
__device__ void keep(Team& team, const StepView<Real>& view, const StepStatus& status,
                     const CudaFrames<Real>& frames, int k) {
  const auto copy = [&](auto* to, const auto* from, int count) {
    copy_to(team, to, from, count, k);
  };
  keep_end(team, view, status, frames, k);
  copy(frames.contact_pressure, view.contact_pressure, view.wall_count);
  copy(frames.plastic, view.cluster_plastic, view.cluster_count);
  if (view.entry_modes)
    copy(frames.plastic_modes, view.cluster_plastic_modes, view.cluster_count * kShapeModes);
  if constexpr (Team::kSolids) {
    copy(frames.solid_points, view.solid_points, kWedgePoints * view.wedge_count);
    copy(frames.solid_plastic_strain, view.solid_plastic_strain, kWedgePoints * view.wedge_count);
  }
}

template <class Real, class Team>
__device__ void run_program(Team& team, const CudaProgram<Real>& program,
                            const StepView<Real>& view) {
  StepStatus status = *program.status;
  Inflator inflator;
  if (program.inflator) inflator = *program.inflator;
  for (int k = 0; k < program.frame_count; ++k) {
    if (status.stage == StepStage::begin) {
      if (status.frame == program.last_frame) break;
      ++status.frame;
      if (program.inflator)
        status.law = inflator.law(status.frame, status.pressure * status.volume, status.volume);
    }
    if (!run_step(team, view, program.rules, program.plasticity, status)) break;
    keep(team, view, status, program.frames, k);
  }
  keep_end(team, view, status, program.frames, program.frame_count);
  team.barrier();
  if (!team.leader()) return;
  *program.status = status;
  if (program.inflator) *program.inflator = inflator;
}

template <class Real>
__host__ __device__ std::size_t block_bytes(const StepView<Real>& view) {
  return std::size_t(view.vertex_count) * sizeof(Vec3T<Real>) +
         std::size_t(view.balloon_count) * sizeof(Move<Real>);
}

template <class Real>
__global__ void __launch_bounds__(kBlockThreads, 1)
    block_kernel(const __grid_constant__ CudaProgram<Real> program) {
  __shared__ BlockShared shared;
  extern __shared__ __align__(16) unsigned char memory[];
  BlockTeam<Real> team(shared);
  __shared__ __align__(16) unsigned char view_memory[sizeof(StepView<Real>)];
  StepView<Real>& view = reinterpret_cast<StepView<Real>&>(view_memory);
  const int count = program.view.vertex_count;
  if (threadIdx.x == 0) {
    view = program.view;
    view.moves = reinterpret_cast<Move<Real>*>(memory);
    view.x = reinterpret_cast<Vec3T<Real>*>(memory + view.balloon_count * sizeof(Move<Real>));
  }
  __syncthreads();
  team.template for_each<1>(count, [&](int v, const auto&) { view.x[v] = program.view.x[v]; });
  team.barrier();
  run_program(team, program, view);
  team.template for_each<1>(count, [&](int v, const auto&) { program.view.x[v] = view.x[v]; });
}

template <class Real, Extent extent>
__global__ void __launch_bounds__(kGridThreads)
    grid_kernel(const __grid_constant__ CudaProgram<Real> program) {
  __shared__ BlockShared shared;
  GridTeam<Real, extent> team(shared, program.sums);
  run_program(team, program, program.view);
}

/// A balloon alone has its own kernels, which need no registers for contact; a layered wall and
/// what the paper projects have theirs, which need many.
template <class Real>
Extent extent_of(const StepView<Real>& view) {
  if (view.columns.levels > 0 || view.paper.is_on || view.paper_gas.is_on) return Extent::solids;
  return view.wall_count == 0 && view.rod.shape.count == 0 && !(view.self_distance > Real(0))
             ? Extent::alone
             : Extent::surroundings;
}

template <class Real>
const void* kernel_of(const StepView<Real>& view, bool grid) {
  if (!grid) return reinterpret_cast<const void*>(block_kernel<Real>);
  switch (extent_of(view)) {
    case Extent::alone:
      return reinterpret_cast<const void*>(grid_kernel<Real, Extent::alone>);
    case Extent::surroundings:
      return reinterpret_cast<const void*>(grid_kernel<Real, Extent::surroundings>);
    default:
      return reinterpret_cast<const void*>(grid_kernel<Real, Extent::solids>);
  }
}

/// Threads that a colour keeps busy.
template <class Real>
int threads_at_work(const StepView<Real>& view) {
  using Alone = GridTeam<Real, Extent::alone>;
  using Beside = GridTeam<Real, Extent::surroundings>;
  using Solids = GridTeam<Real, Extent::solids>;
  const int balloon = view.balloon_count / std::max(1, view.balloon_colors),
            wall = view.wall_count / std::max(1, view.wall_colors);
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
  // No more blocks than a colour has work for: they would only lengthen the barrier.
  shape.threads = kGridThreads;
  shape.blocks = std::clamp((threads_at_work(view) + kGridThreads - 1) / kGridThreads, 1,
                            std::clamp(processors * resident, 1, 1024));
  return shape;
}

template <class Real>
CudaShape cuda_shape(const StepView<Real>& view, int device) {
  constexpr int kMostForOneBlock = 800;  // vertices: more are faster on the whole GPU
  int shared = 0;
  cudaDeviceGetAttribute(&shared, cudaDevAttrMaxSharedMemoryPerBlockOptin, device);
  const bool fits = block_bytes(view) + sizeof(BlockShared) <= std::size_t(shared);
  return cuda_shape(view, device, !fits || view.balloon_count > kMostForOneBlock);
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

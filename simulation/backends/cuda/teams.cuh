#pragma once

#include <cooperative_groups.h>

#include "simulation/backends/cuda_launch.hpp"

/// The teams (team.hpp) that run a step on a GPU: one block, or a grid of them.
namespace angio::simulation::detail {

// Of the one block: four threads for each of the 140 vertices in a colour of a usual balloon, and
// 112 registers for each thread.
inline constexpr int kBlockThreads = 576;
inline constexpr int kGridThreads = 256;
inline constexpr int kWarp = 32;

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
  static constexpr int kBalloonLanes = 4, kVertexLanes = 4, kSlabLanes = 32;

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
  static constexpr int kBalloonLanes = kSurroundings ? 32 : 4,
                       kVertexLanes = kSolids         ? 16
                                      : kSurroundings ? 32
                                                      : 4,
                       kSlabLanes = 32;

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

template <class Real>
__host__ __device__ std::size_t block_bytes(const StepView<Real>& view) {
  return std::size_t(view.motion.count) * sizeof(Vec3T<Real>) +
         std::size_t(view.bodies.balloon().count) * sizeof(Move<Real>);
}

/// The kernels (kernels.cuh), as cudaLaunchKernel takes them.
template <class Real>
const void* block_kernel_pointer();
template <class Real, Extent extent>
const void* grid_kernel_pointer();

}  // namespace angio::simulation::detail

#pragma once

#include "simulation/backends/cuda/teams.cuh"

/// The kernels that run step_program.hpp. Each is compiled by a source of its own, beside this
/// file, so that processors share the work: the largest takes a minute.
namespace angio::simulation::detail {

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

template <class Real>
const void* block_kernel_pointer() {
  return reinterpret_cast<const void*>(block_kernel<Real>);
}
template <class Real, Extent extent>
const void* grid_kernel_pointer() {
  return reinterpret_cast<const void*>(grid_kernel<Real, extent>);
}

}  // namespace angio::simulation::detail

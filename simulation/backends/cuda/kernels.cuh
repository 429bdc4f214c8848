#pragma once

#include "simulation/backends/cuda/teams.cuh"

/// The kernels that run program.hpp. Each is compiled by a source of its own, beside this
/// file, so that processors share the work: the largest takes a minute.
namespace angio::simulation::detail {

// Copies the state into place k of the launch's frames.
template <class Real, class Team>
__device__ void keep(Team& team, const StepView<Real>& view, const StepStatus& status,
                     const CudaFrames<Real>& frames, int k) {
  const StateView<Real> state = state_view(view);
  for_each_state_array(
      [&](const auto& from, const auto& to) {
        team.template for_each<1>(from.count, [&](int i, const auto&) {
          to.data[std::ptrdiff_t(k) * from.count + i] = from.data[i];
        });
      },
      state, frames.state);
  if (team.leader()) frames.status[k] = status;
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
  team.barrier();
  if (!team.leader()) return;
  program.frames.status[program.frame_count] = *program.status = status;
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
  const int count = program.view.motion.count;
  if (threadIdx.x == 0) {
    view = program.view;
    view.balloon.moves = reinterpret_cast<Move<Real>*>(memory);
    view.motion.x =
        reinterpret_cast<Vec3T<Real>*>(memory + view.bodies.balloon().count * sizeof(Move<Real>));
  }
  __syncthreads();
  team.template for_each<1>(
      count, [&](int v, const auto&) { view.motion.x[v] = program.view.motion.x[v]; });
  team.barrier();
  run_program(team, program, view);
  team.template for_each<1>(
      count, [&](int v, const auto&) { program.view.motion.x[v] = view.motion.x[v]; });
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

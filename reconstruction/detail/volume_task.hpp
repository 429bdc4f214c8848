#pragma once

#include <string>
#include <vector>

#include "core/progress.hpp"
#include "reconstruction/detail/back_projection.hpp"
#include "reconstruction/detail/orbit.hpp"
#include "reconstruction/detail/plane_frames.hpp"
#include "reconstruction/reconstruction.hpp"

/// A run's frames, filtered and projected back: by the CPU, or by a GPU.
namespace angio::reconstruction::detail {

struct VolumeTask {
  const RotationalRun& run;
  const Orbit& orbit;
  PlaneGrid plane;
  ColumnGrid columns;
  double air = 0.0;
  FilterWindow window = FilterWindow::shepp_logan;
};

struct ProjectedBack {
  std::vector<float> values;  ///< shape [k_count, j_count, i_count]; 0 outside the field
  double truncated_percent = 0.0;
  GpuSeconds gpu;
};

/// Frames are read some at a time. @throws what the run's pictures throw
ProjectedBack project_back_on_cpu(const VolumeTask& task, const Progress& progress);

/// The same on a GPU. Reading, copying and computing go on at once.
///
/// Values differ from the CPU's by the texture's weights, which have 8 bits (CUDA C++ Programming
/// Guide, "Linear Filtering"): by up to 2^-9 of the step between neighbouring samples of each
/// frame, in either direction.
/// @throws Error  ExitCode::unavailable: there is no GPU, or it failed
ProjectedBack project_back_on_gpu(const VolumeTask& task, const Progress& progress);

/// Frames of a run that the CPU works on together.
int frames_at_a_time(const std::vector<angiogram::ConeBeamFrame>& frames);

/// The name of the GPU that would be used. @throws Error  ExitCode::unavailable: there is none
std::string require_gpu();
/// The same; empty if there is none.
std::string gpu_name();

/// A step of the work, for people.
void report_frame(const Progress& progress, int frame, int count);

}  // namespace angio::reconstruction::detail

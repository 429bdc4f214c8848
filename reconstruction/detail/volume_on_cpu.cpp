#include <fmt/format.h>
#include <omp.h>

#include <algorithm>

#include "reconstruction/detail/frame_filter.hpp"

namespace angio::reconstruction::detail {
namespace {

/// Frames in memory at a time: so many that their filtered values stay in the processor's cache
/// while all voxels are gone through, and at least one a thread.
constexpr std::size_t kBytesAtATime = std::size_t(16) << 20;

}  // namespace

void report_frame(const Progress& progress, int frame, int count) {
  progress.report(double(frame) / count,
                  fmt::format("projecting back, frame {} of {}", frame + 1, count));
}

int frames_at_a_time(const std::vector<angiogram::ConeBeamFrame>& frames) {
  const angiogram::ConeBeamFrame& frame = frames.front();
  const std::size_t bytes = std::size_t(frame.columns) * std::size_t(frame.rows) * sizeof(float);
  return std::clamp(std::max(int(kBytesAtATime / bytes), omp_get_max_threads()), 4, 32);
}

ProjectedBack project_back_on_cpu(const VolumeTask& task, const Progress& progress) {
  FrameFilter filter(task);
  const ColumnGrid& grid = task.columns;
  std::vector<float> columns(
      std::size_t(grid.i_count) * std::size_t(grid.j_count) * std::size_t(grid.k_count), 0.0F);
  const int count = int(task.run.frames.size()), at_a_time = frames_at_a_time(task.run.frames);
  for (int first = 0; first < count; first += at_a_time) {
    report_frame(progress, first, count);
    back_project(filter.filter(first, std::min(at_a_time, count - first)), grid, columns);
  }
  return {to_slices(columns, grid), filter.truncated_percent(), {}};
}

}  // namespace angio::reconstruction::detail

#include "reconstruction/detail/frame_filter.hpp"

#include "core/parallel.hpp"
#include "reconstruction/detail/line_integrals.hpp"
#include "reconstruction/detail/ray_weights.hpp"

namespace angio::reconstruction::detail {

FrameFilter::FrameFilter(const VolumeTask& task)
    : task_(task), ramp_(task.plane.u_count, task.plane.sample_mm, task.window) {}

void FrameFilter::filter_rows(std::vector<float>& plane, std::size_t frame, const PlaneFrame& place,
                              std::size_t& truncated) const {
  const PlaneGrid& grid = task_.plane;
  const std::size_t width = std::size_t(grid.u_count);
  const float sample = float(grid.sample_mm), arc = float(task_.orbit.step[frame]);
  const std::vector<float> weights = ray_weights(task_.orbit, frame, across_mm(place, grid));
  RampFilter::Workspace workspace(ramp_);
  for (int j = 0; j < grid.v_count; ++j) {
    float* row = plane.data() + std::size_t(j) * width;
    truncated += is_truncated(row, grid.u_count);
    const float along = place.first_v + float(j) * sample - place.height;
    for (std::size_t i = 0; i < width; ++i)
      row[i] *= weights[i] * slant_weight(place.radius, place.first_u + float(i) * sample, along);
    ramp_.filter(row, workspace);
    for (std::size_t i = 0; i < width; ++i) row[i] *= arc;
  }
}

FilteredFrames FrameFilter::filter(int first, int count) {
  const RotationalRun& run = task_.run;
  const PlaneGrid& grid = task_.plane;
  const std::size_t pixels =
      std::size_t(run.frames.front().columns) * std::size_t(run.frames.front().rows);
  const std::vector<float> pictures = read_line_integrals(run, first, count, task_.air);
  FilteredFrames filtered;
  filtered.u_count = grid.u_count;
  filtered.v_count = grid.v_count;
  filtered.frames.resize(std::size_t(count));
  const std::size_t samples = std::size_t(grid.u_count) * std::size_t(grid.v_count);
  filtered.values.resize(samples * std::size_t(count));
  std::vector<std::size_t> truncated(std::size_t(count), 0);
  parallel_for(count, [&](std::ptrdiff_t n) {
    const std::size_t index = std::size_t(first) + std::size_t(n);
    const float* picture = pictures.data() + std::size_t(n) * pixels;
    std::vector<float> plane =
        bring_onto_plane(picture, plane_map(run.frames[index], task_.orbit, index, grid), grid);
    const PlaneFrame place = place_on_plane(run.frames[index], task_.orbit, index, grid);
    filter_rows(plane, index, place, truncated[std::size_t(n)]);
    filtered.frames[std::size_t(n)] = place;
    float* turned = filtered.values.data() + std::size_t(n) * samples;
    for (int j = 0; j < grid.v_count; ++j)
      for (int i = 0; i < grid.u_count; ++i)
        turned[std::size_t(i) * std::size_t(grid.v_count) + std::size_t(j)] =
            plane[std::size_t(j) * std::size_t(grid.u_count) + std::size_t(i)];
  });
  rows_ += std::size_t(count) * std::size_t(grid.v_count);
  for (const std::size_t rows : truncated) truncated_ += rows;
  return filtered;
}

}  // namespace angio::reconstruction::detail

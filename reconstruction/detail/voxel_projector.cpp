#include "reconstruction/detail/voxel_projector.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr int kMostAcross = 16;  ///< samples along u that a voxel reaches; larger voxels are cut

/// What a column of voxels gives to the lines along v of a frame.
struct Footprint {
  int first_u = 0, count = 0;
  std::array<float, kMostAcross> weight{};
  float v = 0;       ///< where the lower face of the voxel k = 0 is seen [samples]
  float v_step = 0;  ///< height of a voxel [samples]
};

/// The integral of a trapezoid of height 1 from far left.
double trapezoid_integral(const std::array<double, 4>& t, double u) {
  double sum = 0.0;
  if (u > t[0] && t[1] > t[0]) {
    const double d = std::min(u, t[1]) - t[0];
    sum += 0.5 * d * d / (t[1] - t[0]);
  }
  if (u > t[1]) sum += std::min(u, t[2]) - t[1];
  if (u > t[2] && t[3] > t[2]) {
    const double d = std::min(u, t[3]) - t[2];
    sum += d - 0.5 * d * d / (t[3] - t[2]);
  }
  return sum;
}

Footprint footprint(const PlaneFrame& f, const ColumnGrid& grid, int i, int j, int u_count) {
  const float x = grid.first_x + float(i) * grid.voxel, y = grid.first_y + float(j) * grid.voxel;
  const float half = 0.5F * grid.voxel;
  std::array<double, 4> edges{};
  std::size_t n = 0;
  for (const float dx : {-half, half})
    for (const float dy : {-half, half}) edges[n++] = double(view_column(f, x + dx, y + dy).u);
  std::sort(edges.begin(), edges.end());
  const ColumnView view = view_column(f, x, y);
  Footprint print;
  print.v_step = view.v_per_mm * grid.voxel;
  print.v = view.v + view.v_per_mm * (grid.first_z - half);
  const double dx = double(x) - double(f.radius) * double(f.source_x),
               dy = double(y) - double(f.radius) * double(f.source_y);
  const double length =
      double(grid.voxel) * std::hypot(dx, dy) / std::max(std::abs(dx), std::abs(dy));
  const int first = std::max(0, int(std::lround(edges[0])));
  const int last = std::min({u_count - 1, int(std::lround(edges[3])), first + kMostAcross - 1});
  print.first_u = first;
  print.count = std::max(0, last - first + 1);
  double before = trapezoid_integral(edges, first - 0.5);
  for (int u = first; u <= last; ++u) {
    const double up_to = trapezoid_integral(edges, u + 0.5);
    print.weight[std::size_t(u - first)] = float(length * (up_to - before));
    before = up_to;
  }
  return print;
}

/// Calls use(sample along v, overlap in samples, voxel of the run) where they overlap.
template <class Use>
void for_each_overlap(const Footprint& print, const VoxelRun& run, int v_count, const Use& use) {
  for (int n = 0; n < run.count; ++n) {
    const float low = print.v + float(run.first_k + n) * print.v_step + 0.5F;
    const float high = low + print.v_step;
    const int first = std::max(0, int(std::floor(low)));
    for (int v = first; v < v_count && float(v) < high; ++v)
      use(v, std::min(high, float(v) + 1.0F) - std::max(low, float(v)), n);
  }
}

/// The samples along v that a run of voxels reaches: [first, last).
struct Span {
  int first = 0, last = 0;
};
Span span_of(const Footprint& print, const VoxelRun& run, int v_count) {
  const float low = print.v + float(run.first_k) * print.v_step + 0.5F;
  const float high = low + float(run.count) * print.v_step;
  return {std::clamp(int(std::floor(low)), 0, v_count),
          std::clamp(int(std::floor(high)) + 2, 0, v_count)};
}

}  // namespace

std::vector<float> project(const ChosenVoxels& voxels, const std::vector<float>& values,
                           const FrameStack& like, const std::vector<int>& which) {
  std::vector<float> samples(like.per_frame() * which.size(), 0.0F);
  parallel_for_uneven(std::ptrdiff_t(which.size()), [&](std::ptrdiff_t n) {
    const PlaneFrame& place = like.places[std::size_t(which[std::size_t(n)])];
    float* frame = samples.data() + std::size_t(n) * like.per_frame();
    std::vector<float> line(static_cast<std::size_t>(like.v_count));
    for (const VoxelRun& run : voxels.runs) {
      const Footprint print = footprint(place, voxels.grid, run.i, run.j, like.u_count);
      const Span span = span_of(print, run, like.v_count);
      if (print.count == 0 || span.first >= span.last) continue;
      std::fill(line.begin() + span.first, line.begin() + span.last, 0.0F);
      const float* value = values.data() + run.offset;
      for_each_overlap(print, run, like.v_count,
                       [&](int v, float part, int k) { line[std::size_t(v)] += part * value[k]; });
      for (int u = 0; u < print.count; ++u) {
        const float weight = print.weight[std::size_t(u)];
        float* to = frame + std::size_t(print.first_u + u) * std::size_t(like.v_count);
        for (int v = span.first; v < span.last; ++v) to[v] += weight * line[std::size_t(v)];
      }
    }
  });
  return samples;
}

std::vector<float> project_back(const ChosenVoxels& voxels, const std::vector<float>& samples,
                                const FrameStack& like, const std::vector<int>& which) {
  std::vector<float> values(voxels.count, 0.0F);
  parallel_for_uneven(std::ptrdiff_t(voxels.runs.size()), [&](std::ptrdiff_t r) {
    const VoxelRun& run = voxels.runs[std::size_t(r)];
    std::vector<float> line(static_cast<std::size_t>(like.v_count));
    float* value = values.data() + run.offset;
    for (std::size_t n = 0; n < which.size(); ++n) {
      const Footprint print =
          footprint(like.places[std::size_t(which[n])], voxels.grid, run.i, run.j, like.u_count);
      const Span span = span_of(print, run, like.v_count);
      if (print.count == 0 || span.first >= span.last) continue;
      std::fill(line.begin() + span.first, line.begin() + span.last, 0.0F);
      const float* frame = samples.data() + n * like.per_frame();
      for (int u = 0; u < print.count; ++u) {
        const float weight = print.weight[std::size_t(u)];
        const float* from = frame + std::size_t(print.first_u + u) * std::size_t(like.v_count);
        for (int v = span.first; v < span.last; ++v) line[std::size_t(v)] += weight * from[v];
      }
      for_each_overlap(print, run, like.v_count,
                       [&](int v, float part, int k) { value[k] += part * line[std::size_t(v)]; });
    }
  });
  return values;
}

}  // namespace angio::reconstruction::detail

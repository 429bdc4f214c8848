#include "reconstruction/detail/back_projection.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"

namespace angio::reconstruction::detail {
namespace {

// Compiled twice, and chosen when the program starts: with gathers, and for any processor. Both
// give the same bits.
#define ANGIO_WIDE [[gnu::target_clones("avx2", "default")]]

/// The frame's line at a fraction between two of its lines.
ANGIO_WIDE void blend_lines(const float* low, const float* high, float part, int count,
                            float* line) {
  for (int v = 0; v < count; ++v) line[v] = low[v] + part * (high[v] - low[v]);
}

ANGIO_WIDE void add_line(const float* line, int count, float first, float step, float weight,
                         int k_count, float* sums) {
  const float last = float(count - 1) - 1e-3F;
  for (int k = 0; k < k_count; ++k) {
    const float v = std::min(std::max(first + float(k) * step, 0.0F), last);
    const int low = int(v);
    const float part = v - float(low);
    sums[k] += weight * (line[low] + part * (line[low + 1] - line[low]));
  }
}

}  // namespace

void back_project(const FilteredFrames& frames, const ColumnGrid& grid, std::vector<float>& sums) {
  const std::size_t per_line = std::size_t(frames.v_count),
                    per_frame = per_line * std::size_t(frames.u_count);
  const float field = grid.field_radius * grid.field_radius;
  parallel_for_uneven(grid.j_count, [&](std::ptrdiff_t j) {
    std::vector<float> line(per_line + 1);
    const float y = grid.first_y + float(j) * grid.voxel;
    for (int i = 0; i < grid.i_count; ++i) {
      const float x = grid.first_x + float(i) * grid.voxel;
      if (x * x + y * y > field) continue;
      float* column = sums.data() + (std::size_t(j) * std::size_t(grid.i_count) + std::size_t(i)) *
                                        std::size_t(grid.k_count);
      for (std::size_t f = 0; f < frames.frames.size(); ++f) {
        const ColumnView view = view_column(frames.frames[f], x, y);
        if (!(view.u >= 0.0F && view.u < float(frames.u_count - 1))) continue;
        const int low = int(view.u);
        const float* values = frames.values.data() + f * per_frame + std::size_t(low) * per_line;
        const float first = view.v + view.v_per_mm * grid.first_z;
        const float step = view.v_per_mm * grid.voxel;
        const float last = first + step * float(grid.k_count - 1);
        const int from = std::clamp(int(std::floor(first)), 0, frames.v_count - 2);
        const int to = std::clamp(int(std::ceil(last)) + 1, from + 2, frames.v_count);
        blend_lines(values + from, values + from + per_line, view.u - float(low), to - from,
                    line.data());
        add_line(line.data(), to - from, first - float(from), step, view.weight, grid.k_count,
                 column);
      }
    }
  });
}

}  // namespace angio::reconstruction::detail

#include "reconstruction/detail/back_projection.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace angio::reconstruction::detail {
namespace {

// What follows is compiled for processors with AVX2 and for any; both give the same bits.
#ifdef __x86_64__
#define ANGIO_WIDE [[gnu::target_clones("avx2", "default")]]
#else
#define ANGIO_WIDE
#endif

/// The frame's line at a fraction between two of its lines.
ANGIO_WIDE void blend_lines(const float* low, const float* high, float part, int count,
                            float* line) {
  for (int v = 0; v < count; ++v) line[v] = low[v] + part * (high[v] - low[v]);
}

/// A blended line, its last sample twice, and where a column of voxels lies on it.
struct SeenColumn {
  const float* line = nullptr;
  int count = 0;              ///< of the line's samples, >= 2
  float first = 0, step = 0;  ///< the sample of the first voxel; from a voxel to the next
  float weight = 1;
};

void add_voxels(const SeenColumn& seen, int first_k, int k_count, float* sums) {
  const float last = float(seen.count - 1);
  for (int k = first_k; k < k_count; ++k) {
    const float v = std::min(std::max(seen.first + float(k) * seen.step, 0.0F), last);
    const int low = int(v);
    const float part = v - float(low);
    sums[k] += seen.weight * (seen.line[low] + part * (seen.line[low + 1] - seen.line[low]));
  }
}

#ifdef __x86_64__
[[gnu::target("avx2")]] inline __m256 load_pairs(const double* pairs, __m128i at) {
  const __m256d none = _mm256_setzero_pd(), all = _mm256_cmp_pd(none, none, _CMP_EQ_OQ);
  return _mm256_castpd_ps(_mm256_mask_i32gather_pd(none, pairs, at, all, sizeof(float)));
}

/// Eight voxels at a time; a sample and the next are loaded together.
/// @return how many voxels were done
[[gnu::target("avx2")]] int add_eights(const SeenColumn& seen, int k_count, float* sums) {
  const __m256 last = _mm256_set1_ps(float(seen.count - 1)), eight = _mm256_set1_ps(8.0F);
  const __m256 first = _mm256_set1_ps(seen.first), step = _mm256_set1_ps(seen.step),
               weight = _mm256_set1_ps(seen.weight);
  // In the order in which shuffles of halves leave pairs.
  __m256 index = _mm256_setr_ps(0, 1, 4, 5, 2, 3, 6, 7);
  int k = 0;
  for (; k + 8 <= k_count; k += 8) {
    const __m256 at = _mm256_add_ps(first, _mm256_mul_ps(index, step));
    const __m256 v = _mm256_min_ps(_mm256_max_ps(at, _mm256_setzero_ps()), last);
    index = _mm256_add_ps(index, eight);
    const __m256i low = _mm256_cvttps_epi32(v);
    const __m256 part = _mm256_sub_ps(v, _mm256_cvtepi32_ps(low));
    const auto* pairs = reinterpret_cast<const double*>(seen.line);  // of neighbours
    const __m256 a = load_pairs(pairs, _mm256_castsi256_si128(low)),
                 b = load_pairs(pairs, _mm256_extracti128_si256(low, 1));
    const __m256 here = _mm256_shuffle_ps(a, b, 0x88), next = _mm256_shuffle_ps(a, b, 0xdd);
    const __m256 in_order = _mm256_castpd_ps(_mm256_permute4x64_pd(_mm256_castps_pd(part), 0xd8));
    const __m256 value = _mm256_add_ps(here, _mm256_mul_ps(in_order, _mm256_sub_ps(next, here)));
    _mm256_storeu_ps(sums + k,
                     _mm256_add_ps(_mm256_loadu_ps(sums + k), _mm256_mul_ps(weight, value)));
  }
  return k;
}
#endif

void add_column(const SeenColumn& seen, int k_count, float* sums) {
  int done = 0;
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) done = add_eights(seen, k_count, sums);
#endif
  add_voxels(seen, done, k_count, sums);
}

/// Adds what a frame gives to a column.
/// @param line  room for a line and one sample more
void add_frame_to_column(const FilteredFrames& frames, std::size_t f, const ColumnGrid& grid,
                         const ColumnView& view, std::vector<float>& line, float* sums) {
  const std::size_t per_line = std::size_t(frames.v_count);
  const int low = int(view.u);
  const float* values =
      frames.values.data() + (f * std::size_t(frames.u_count) + std::size_t(low)) * per_line;
  const float first = view.v + view.v_per_mm * grid.first_z, step = view.v_per_mm * grid.voxel;
  const float last = first + step * float(grid.k_count - 1);
  const int from = std::clamp(int(std::floor(first)), 0, frames.v_count - 2);
  const int to = std::clamp(int(std::ceil(last)) + 1, from + 2, frames.v_count);
  blend_lines(values + from, values + from + per_line, view.u - float(low), to - from, line.data());
  line[std::size_t(to - from)] = line[std::size_t(to - from) - 1];
  add_column({line.data(), to - from, first - float(from), step, view.weight}, grid.k_count, sums);
}

/// Columns of a tile see the same few lines of a frame, which stay in the processor's cache with
/// the tile's voxels.
constexpr int kTile = 8;

void add_tile(const FilteredFrames& frames, const ColumnGrid& grid, int first_i, int first_j,
              std::vector<float>& sums) {
  std::vector<float> line(std::size_t(frames.v_count) + 1);
  const float field = grid.field_radius * grid.field_radius;
  for (std::size_t f = 0; f < frames.frames.size(); ++f)
    for (int j = first_j; j < std::min(first_j + kTile, grid.j_count); ++j)
      for (int i = first_i; i < std::min(first_i + kTile, grid.i_count); ++i) {
        const float x = grid.first_x + float(i) * grid.voxel,
                    y = grid.first_y + float(j) * grid.voxel;
        if (x * x + y * y > field) continue;
        const ColumnView view = view_column(frames.frames[f], x, y);
        if (!(view.u >= 0.0F && view.u < float(frames.u_count - 1))) continue;
        const std::size_t column = std::size_t(j) * std::size_t(grid.i_count) + std::size_t(i);
        add_frame_to_column(frames, f, grid, view, line,
                            sums.data() + column * std::size_t(grid.k_count));
      }
}

}  // namespace

void back_project(const FilteredFrames& frames, const ColumnGrid& grid, std::vector<float>& sums) {
  const int across = (grid.i_count + kTile - 1) / kTile, down = (grid.j_count + kTile - 1) / kTile;
  parallel_for_uneven(std::ptrdiff_t(across) * down, [&](std::ptrdiff_t tile) {
    add_tile(frames, grid, int(tile % across) * kTile, int(tile / across) * kTile, sums);
  });
}

std::vector<float> to_slices(const std::vector<float>& columns, const ColumnGrid& grid) {
  constexpr int kTogether = 16;  // of a column: a line of the cache
  const std::size_t ni = std::size_t(grid.i_count), nj = std::size_t(grid.j_count),
                    nk = std::size_t(grid.k_count);
  std::vector<float> slices(columns.size());
  parallel_for(grid.j_count, [&](std::ptrdiff_t j) {
    for (std::size_t first = 0; first < nk; first += kTogether)
      for (std::size_t i = 0; i < ni; ++i) {
        const float* column = columns.data() + (std::size_t(j) * ni + i) * nk;
        for (std::size_t k = first; k < std::min(first + kTogether, nk); ++k)
          slices[(k * nj + std::size_t(j)) * ni + i] = column[k];
      }
  });
  return slices;
}

}  // namespace angio::reconstruction::detail

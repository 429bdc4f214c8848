#include "reconstruction/detail/total_variation.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"

namespace angio::reconstruction::detail {
namespace {

using Dual = std::vector<std::array<float, 3>>;
constexpr std::ptrdiff_t kBlock = 4096;  ///< voxels a thread takes at a time

template <class Body>
void for_each_voxel(std::size_t count, const Body& body) {
  const auto blocks = std::ptrdiff_t((count + std::size_t(kBlock) - 1) / std::size_t(kBlock));
  parallel_for(blocks, [&](std::ptrdiff_t b) {
    const std::size_t first = std::size_t(b * kBlock),
                      last = std::min(count, first + std::size_t(kBlock));
    for (std::size_t v = first; v < last; ++v) body(v);
  });
}

std::array<float, 3> gradient(const std::vector<float>& x, const Neighbours& beside,
                              std::size_t v) {
  std::array<float, 3> g{};
  for (std::size_t a = 0; a < 3; ++a) {
    const int after = beside.after[v][a];
    g[a] = (after >= 0 ? x[std::size_t(after)] : 0.0F) - x[v];
  }
  return g;
}

/// The gradient's transpose.
float spread(const Dual& dual, const Neighbours& beside, std::size_t v) {
  float sum = 0.0F;
  for (std::size_t a = 0; a < 3; ++a) {
    const int before = beside.before[v][a];
    sum += (before >= 0 ? dual[std::size_t(before)][a] : 0.0F) - dual[v][a];
  }
  return sum;
}

}  // namespace

Neighbours neighbours(const ChosenVoxels& voxels) {
  const ColumnGrid& g = voxels.grid;
  // Of each column where its runs begin in the list.
  std::vector<int> first(std::size_t(g.i_count) * std::size_t(g.j_count) + 1,
                         int(voxels.runs.size()));
  const auto column = [&](int i, int j) {
    return std::size_t(j) * std::size_t(g.i_count) + std::size_t(i);
  };
  for (std::size_t r = voxels.runs.size(); r-- > 0;)
    first[column(voxels.runs[r].i, voxels.runs[r].j)] = int(r);
  const auto find = [&](int i, int j, int k) {
    if (i < 0 || j < 0 || i >= g.i_count || j >= g.j_count) return -1;
    for (std::size_t r = std::size_t(first[column(i, j)]); r < voxels.runs.size(); ++r) {
      const VoxelRun& run = voxels.runs[r];
      if (run.i != i || run.j != j || run.first_k > k) break;
      if (k < run.first_k + run.count) return int(run.offset) + k - run.first_k;
    }
    return -1;
  };
  Neighbours beside;
  beside.after.resize(voxels.count);
  beside.before.resize(voxels.count);
  parallel_for(std::ptrdiff_t(voxels.runs.size()), [&](std::ptrdiff_t r) {
    const VoxelRun& run = voxels.runs[std::size_t(r)];
    for (int n = 0; n < run.count; ++n) {
      const int i = run.i, j = run.j, k = run.first_k + n;
      const std::size_t v = run.offset + std::size_t(n);
      beside.after[v] = {find(i + 1, j, k), find(i, j + 1, k), find(i, j, k + 1)};
      beside.before[v] = {find(i - 1, j, k), find(i, j - 1, k), find(i, j, k - 1)};
    }
  });
  return beside;
}

std::vector<float> smooth_by_total_variation(const std::vector<float>& noisy, float strength,
                                             const Neighbours& beside, int iterations, Dual& dual) {
  const std::size_t count = noisy.size();
  dual.resize(count);
  std::vector<float> x(count);
  const auto primal = [&](const Dual& p) {
    for_each_voxel(count, [&](std::size_t v) {
      x[v] = std::max(0.0F, noisy[v] - strength * spread(p, beside, v));
    });
  };
  if (strength > 0.0F) {
    Dual ahead = dual, last = dual;
    const float step = 1.0F / (12.0F * strength);
    float t = 1.0F;
    for (int n = 0; n < iterations; ++n) {
      primal(ahead);
      std::swap(last, dual);
      for_each_voxel(count, [&](std::size_t v) {
        const auto g = gradient(x, beside, v);
        std::array<float, 3> p{};
        float squared = 0.0F;
        for (std::size_t a = 0; a < 3; ++a) {
          p[a] = ahead[v][a] + step * g[a];
          squared += p[a] * p[a];
        }
        const float scale = 1.0F / std::max(1.0F, std::sqrt(squared));
        for (std::size_t a = 0; a < 3; ++a) dual[v][a] = scale * p[a];
      });
      const float t_next = 0.5F * (1.0F + std::sqrt(1.0F + 4.0F * t * t));
      const float momentum = (t - 1.0F) / t_next;
      for_each_voxel(count, [&](std::size_t v) {
        for (std::size_t a = 0; a < 3; ++a)
          ahead[v][a] = dual[v][a] + momentum * (dual[v][a] - last[v][a]);
      });
      t = t_next;
    }
  }
  primal(dual);
  return x;
}

double total_variation(const std::vector<float>& values, const Neighbours& beside) {
  double sum = 0.0;
  for (std::size_t v = 0; v < values.size(); ++v) {
    const auto g = gradient(values, beside, v);
    sum += std::sqrt(double(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]));
  }
  return sum;
}

}  // namespace angio::reconstruction::detail

#include "segmentation/detail/take_out.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include "segmentation/detail/local_mean.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kShellVoxels = 2.6;  ///< two blurs of 0.8 voxels and a voxel

}  // namespace

std::array<int, 3> voxel_of(const VolumeGeometry& grid, std::size_t v) {
  const auto ni = std::size_t(grid.size[0]), nj = std::size_t(grid.size[1]);
  return {int(v % ni), int(v / ni % nj), int(v / ni / nj)};
}

void add_shells(Volume<std::uint8_t>& mask, const Volume<float>& denoised, float tolerance,
                const Volume<std::uint8_t>& kept) {
  const VolumeGeometry& grid = mask.geometry;
  std::vector<std::pair<std::size_t, std::size_t>> front;  // voxel, and that of the core behind it
  for (std::size_t v = 0; v < mask.values.size(); ++v)
    if (mask.values[v]) front.emplace_back(v, v);
  while (!front.empty()) {
    std::vector<std::pair<std::size_t, std::size_t>> next;
    for (const auto& entry : front) {
      const auto here = voxel_of(grid, entry.first), core = voxel_of(grid, entry.second);
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (int side : {-1, 1}) {
          auto there = here;
          there[axis] += side;
          if (!grid.contains(there[0], there[1], there[2])) continue;
          const std::size_t n = grid.offset(there[0], there[1], there[2]);
          if (mask.values[n] || (!kept.values.empty() && kept.values[n]) ||
              denoised.values[n] > denoised.values[entry.first] + tolerance ||
              std::hypot(there[0] - core[0], there[1] - core[1], there[2] - core[2]) > kShellVoxels)
            continue;
          mask.values[n] = 1;
          next.emplace_back(n, entry.second);
        }
    }
    front = std::move(next);
  }
}

Volume<float> take_out(const Volume<float>& volume, const Volume<std::uint8_t>& mask, float half) {
  const auto is_background = [&](std::size_t v) {
    return !mask.values[v] && volume.values[v] < half ? 1.0f : 0.0f;
  };
  double sum = 0.0, count = 0.0;
  for (std::size_t v = 0; v < mask.values.size(); ++v)
    if (is_background(v) > 0.0f) {
      sum += double(volume.values[v]);
      count += 1.0;
    }
  const CoarseField background = local_mean(
      volume.geometry, count > 0.0 ? float(sum / count) : half,
      [&](std::size_t v) { return volume.values[v]; }, is_background);
  Volume<float> result = volume;
  const auto& size = volume.geometry.size;
  parallel_for(size[2], [&](std::ptrdiff_t k) {
    std::vector<float> row(static_cast<std::size_t>(size[0]));
    for (int j = 0; j < size[1]; ++j) {
      background.row(j, int(k), size[0], row.data());
      for (int i = 0; i < size[0]; ++i)
        if (mask.at(i, j, int(k))) result.at(i, j, int(k)) = row[std::size_t(i)];
    }
  });
  return result;
}

}  // namespace angio::segmentation::detail

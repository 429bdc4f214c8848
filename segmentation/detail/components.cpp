#include "segmentation/detail/components.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace angio::segmentation::detail {
namespace {

std::vector<std::array<int, 3>> neighbor_steps(Connectivity connectivity) {
  std::vector<std::array<int, 3>> steps;
  for (int dk = -1; dk <= 1; ++dk)
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di) {
        const int distance = std::abs(di) + std::abs(dj) + std::abs(dk);
        if (distance == 1 || (distance > 1 && connectivity == Connectivity::corners))
          steps.push_back({di, dj, dk});
      }
  return steps;
}

}  // namespace

Components label_components(const Volume<std::uint8_t>& mask, Connectivity connectivity) {
  const auto& geometry = mask.geometry;
  const auto steps = neighbor_steps(connectivity);
  Components components{std::vector<std::int32_t>(geometry.voxel_count(), 0), {0}};
  std::vector<std::size_t> front;
  const auto size_i = std::size_t(geometry.size[0]);
  const auto size_ij = size_i * std::size_t(geometry.size[1]);
  for (std::size_t start = 0; start < mask.values.size(); ++start) {
    if (!mask.values[start] || components.label[start] != 0) continue;
    components.voxel_count.push_back(0);
    const auto label = std::int32_t(components.count());
    components.label[start] = label;
    front.push_back(start);
    while (!front.empty()) {
      const std::size_t v = front.back();
      front.pop_back();
      ++components.voxel_count.back();
      const int i = int(v % size_i), j = int(v % size_ij / size_i), k = int(v / size_ij);
      for (const auto& [di, dj, dk] : steps) {
        if (!geometry.contains(i + di, j + dj, k + dk)) continue;
        const std::size_t n = geometry.offset(i + di, j + dj, k + dk);
        if (!mask.values[n] || components.label[n] != 0) continue;
        components.label[n] = label;
        front.push_back(n);
      }
    }
  }
  return components;
}

VoxelBox bounding_box(const Volume<std::uint8_t>& mask, double margin_mm) {
  const auto& geometry = mask.geometry;
  std::array<int, 3> low = geometry.size;
  std::array<int, 3> high{-1, -1, -1};
  for (int k = 0; k < geometry.size[2]; ++k)
    for (int j = 0; j < geometry.size[1]; ++j)
      for (int i = 0; i < geometry.size[0]; ++i) {
        if (!mask.at(i, j, k)) continue;
        low = {std::min(low[0], i), std::min(low[1], j), std::min(low[2], k)};
        high = {std::max(high[0], i), std::max(high[1], j), std::max(high[2], k)};
      }
  VoxelBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    if (high[a] < 0) return {{0, 0, 0}, geometry.size};
    const int margin = std::max(3, int(std::ceil(margin_mm / geometry.spacing[int(a)])));
    box.first[a] = std::max(0, low[a] - margin);
    box.size[a] = std::min(geometry.size[a], high[a] + 1 + margin) - box.first[a];
  }
  return box;
}

}  // namespace angio::segmentation::detail

#include "segmentation/detail/blood_pools.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/parallel.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kBlock = 1.0;        ///< [mm] of the grid on which bodies are sought
constexpr double kReach = 2.0;        ///< [mm] standard deviation of the neighbourhood
constexpr double kReachVoxels = 1.5;  ///< and no less
constexpr float kCore = 0.65f;        ///< of the way from tissue to blood
constexpr float kDeep = 0.85f;        ///< of the neighbourhood in the core
constexpr float kEdge = 0.1f;         ///< of the neighbourhood deep: still the body
constexpr float kRim = 0.35f;         ///< contrasts brighter than blood: cortex
constexpr double kRimShare = 0.25;    ///< of the rim

/// Of each block, the part of its voxels above a level.
Volume<float> part_above(const Volume<float>& volume, float level,
                         const std::array<int, 3>& factor) {
  Volume<float> above(volume.geometry);
  parallel_for(volume.geometry.size[2], [&](std::ptrdiff_t k) {
    const std::size_t slice = above.values.size() / std::size_t(volume.geometry.size[2]);
    for (std::size_t v = std::size_t(k) * slice; v < std::size_t(k + 1) * slice; ++v)
      above.values[v] = volume.values[v] > level ? 1.0f : 0.0f;
  });
  return block_average(above, factor);
}

/// Takes the bodies with a bright rim out. @param deep  1 inside; pieces of it are changed
void drop_bones(const Volume<float>& blocks, const BloodLevel& level, double reach,
                Volume<std::uint8_t>& deep) {
  const Components bodies = label_components(deep, Connectivity::faces);
  std::vector<double> rim(std::size_t(bodies.count()) + 1, 0.0), bright(rim.size(), 0.0);
  const auto& size = deep.geometry.size;
  std::array<int, 3> steps{};
  for (std::size_t a = 0; a < 3; ++a)
    steps[a] = std::max(1, int(2.0 * reach / deep.geometry.spacing[int(a)]));
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        const auto label = std::size_t(bodies.label[deep.geometry.offset(i, j, k)]);
        if (label == 0) continue;
        // The brightest block on the way out, along each axis that leaves the body here.
        for (std::size_t a = 0; a < 3; ++a)
          for (int side : {-1, 1}) {
            std::array<int, 3> at{i, j, k};
            at[a] += side;
            if (!deep.geometry.contains(at[0], at[1], at[2]) || deep.at(at[0], at[1], at[2]))
              continue;
            float highest = blocks.at(i, j, k);
            for (int n = 0; n < steps[a] && deep.geometry.contains(at[0], at[1], at[2]);
                 ++n, at[a] += side)
              highest = std::max(highest, blocks.at(at[0], at[1], at[2]));
            rim[label] += 1.0;
            bright[label] += highest > level.lumen + kRim * level.contrast() &&
                             highest > blocks.at(i, j, k) + kRim * level.contrast();
          }
      }
  for (std::size_t v = 0; v < deep.values.size(); ++v) {
    const auto label = std::size_t(bodies.label[v]);
    if (label > 0 && bright[label] > kRimShare * rim[label]) deep.values[v] = 0;
  }
}

}  // namespace

void add_pools(const Volume<float>& smoothed, const BloodLevel& level,
               const SegmentationOptions& options, Volume<std::uint8_t>& mask) {
  const VolumeGeometry& voxels = smoothed.geometry;
  const double reach = std::max(kReach, kReachVoxels * mean_spacing(voxels));
  const auto factor = block_size(voxels, kBlock);
  const Volume<float> core =
      smooth(part_above(smoothed, level.tissue + kCore * level.contrast(), factor), reach);
  Volume<std::uint8_t> deep(core.geometry);
  for (std::size_t v = 0; v < core.values.size(); ++v) deep.values[v] = core.values[v] > kDeep;
  if (std::find(deep.values.begin(), deep.values.end(), 1) == deep.values.end()) return;
  drop_bones(block_average(smoothed, factor), level, reach, deep);
  Volume<float> around(core.geometry);
  std::copy(deep.values.begin(), deep.values.end(), around.values.begin());
  const CoarseField body(smooth(around, reach), factor);
  const auto lowest = std::max(float(options.intensity_min.value_or(-1e30)), level.half());
  const auto highest = float(options.intensity_max.value_or(1e30));
  parallel_for(voxels.size[2], [&](std::ptrdiff_t k) {
    std::vector<float> row(static_cast<std::size_t>(voxels.size[0]));
    for (int j = 0; j < voxels.size[1]; ++j) {
      body.row(j, int(k), voxels.size[0], row.data());
      for (int i = 0; i < voxels.size[0]; ++i) {
        const float value = smoothed.at(i, j, int(k));
        if (row[std::size_t(i)] > kEdge && value > lowest && value <= highest)
          mask.at(i, j, int(k)) = kLumen;
      }
    }
  });
}

}  // namespace angio::segmentation::detail

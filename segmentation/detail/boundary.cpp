#include "segmentation/detail/boundary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "segmentation/detail/blur.hpp"
#include "segmentation/detail/bridge.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/intensity_levels.hpp"
#include "segmentation/detail/signed_distance.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr int kIterationCount = 3;
constexpr double kFirstBlurVoxels = 0.8;  ///< assumed until it is measured
constexpr double kReachMm = 5.0;          ///< to which the level set tells distances outside
constexpr float kLeastShare = 0.2f;       ///< of the contrast: T never goes below
constexpr double kVoxelBudget = 32e6;     ///< of the result
constexpr float kPeakShare = 0.7f;        ///< T stays below this share of the local peak

/// The highest value within one voxel.
Volume<float> local_peak(const Volume<float>& volume) {
  constexpr int kReach = 1;
  Volume<float> peak = volume;
  const auto size = volume.geometry.size;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Volume<float> before = peak;
    parallel_for(size[2], [&](std::ptrdiff_t k) {
      for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i) {
          std::array<int, 3> voxel{i, j, int(k)};
          const int middle = voxel[axis];
          float highest = before.at(i, j, int(k));
          for (int t = std::max(0, middle - kReach); t <= std::min(size[axis] - 1, middle + kReach);
               ++t) {
            voxel[axis] = t;
            highest = std::max(highest, before.at(voxel[0], voxel[1], voxel[2]));
          }
          peak.at(i, j, int(k)) = highest;
        }
    });
  }
  return peak;
}

/// -F: negative where the voxel is more than half lumen.
Volume<float> level_function(const Volume<float>& volume, const Volume<float>& peak,
                             const IntensityLevels& levels, const SegmentationOptions& options) {
  const float least_contrast = 0.1f * (levels.lumen_overall - levels.background_overall);
  const auto lowest = float(options.intensity_min.value_or(-1e30));
  const auto highest = float(options.intensity_max.value_or(1e30));
  Volume<float> level(volume.geometry);
  const auto [ni, nj, nk] = volume.geometry.size;
  parallel_for(nk, [&, ni = ni, nj = nj](std::ptrdiff_t k) {
    const auto width = std::size_t(ni);
    std::vector<float> lumen(width), background(width);
    for (int j = 0; j < nj; ++j) {
      levels.lumen.row(j, int(k), ni, lumen.data());
      levels.background.row(j, int(k), ni, background.data());
      for (int i = 0; i < ni; ++i) {
        const float b = background[std::size_t(i)];
        const float contrast = std::max(lumen[std::size_t(i)] - b, least_contrast);
        const float half = b + 0.5f * contrast;
        const float below_peak = b + kPeakShare * (peak.at(i, j, int(k)) - b);
        const float threshold =
            std::max({std::min(half, below_peak), b + kLeastShare * contrast, lowest});
        const float value = volume.at(i, j, int(k));
        float excess = (value - threshold) / contrast;
        if (value > highest) excess = -0.5f;
        level.at(i, j, int(k)) = -std::clamp(excess, -1.0f, 1.0f);
      }
    }
  });
  return level;
}

/// Turns other pieces than the tree's into outside, and closed holes into inside.
/// @param tree        the piece with most of it stays
/// @param all_above   [mm^3] other pieces with as much of the tree in them stay too
void keep_tree_only(Volume<float>& level, const Volume<std::uint8_t>& tree, double all_above) {
  Volume<std::uint8_t> inside(level.geometry);
  for (std::size_t v = 0; v < level.values.size(); ++v) inside.values[v] = level.values[v] < 0.0f;
  const Components pieces = label_components(inside, Connectivity::faces);
  std::vector<std::size_t> overlap(std::size_t(pieces.count()) + 1, 0);
  for (std::size_t v = 0; v < level.values.size(); ++v)
    if (pieces.label[v] > 0 && tree.values[v]) ++overlap[std::size_t(pieces.label[v])];
  const Vec3& h = level.geometry.spacing;
  std::vector<bool> kept;
  for (std::size_t count : overlap) kept.push_back(double(count) * h.x * h.y * h.z > all_above);
  kept[std::size_t(std::max_element(overlap.begin(), overlap.end()) - overlap.begin())] = true;
  for (std::size_t v = 0; v < level.values.size(); ++v) {
    if (pieces.label[v] > 0 && !kept[std::size_t(pieces.label[v])])
      level.values[v] = -level.values[v];
    inside.values[v] = level.values[v] >= 0.0f;
  }
  const Components holes = label_components(inside, Connectivity::faces);
  const auto outside = std::max_element(holes.voxel_count.begin(), holes.voxel_count.end()) -
                       holes.voxel_count.begin();
  for (std::size_t v = 0; v < level.values.size(); ++v)
    if (holes.label[v] > 0 && holes.label[v] != outside)
      level.values[v] = -std::max(level.values[v], 1e-3f);
}

/// The spacing of the result: even along all axes, and as fine as half the input's finest if that
/// keeps the grid within a budget, so that narrow vessels keep their shape.
Vec3 fine_spacing(const VolumeGeometry& geometry) {
  const Vec3& h = geometry.spacing;
  const double finest = std::min({h.x, h.y, h.z});
  const double volume = double(geometry.voxel_count()) * h.x * h.y * h.z;
  const double affordable = std::cbrt(volume / kVoxelBudget);
  const double even = std::max(0.5 * finest, affordable);
  return even < 0.8 * finest                                  ? Vec3{even, even, even}
         : even < finest || h == Vec3{finest, finest, finest} ? Vec3{finest, finest, finest}
                                                              : h;
}

}  // namespace

Boundary find_boundary(const Volume<float>& volume, const Volume<std::uint8_t>& tree,
                       const SegmentationOptions& options, const Progress& progress) {
  Volume<float> level(volume.geometry);
  for (std::size_t v = 0; v < level.values.size(); ++v)
    level.values[v] = tree.values[v] ? -0.5f : 0.5f;
  const Volume<float> peak = local_peak(volume);
  const double voxel = mean_spacing(level.geometry);
  // One seed or none gives one tree; with more, each may have its own.
  const double all_above = options.seeds_lps_mm.size() > 1
                               ? options.min_component_mm3
                               : std::numeric_limits<double>::infinity();
  Volume<float> distance = signed_distance(level, kReachMm);
  Boundary boundary;
  boundary.blur_mm = kFirstBlurVoxels * voxel;
  for (int iteration = 0; iteration < kIterationCount; ++iteration) {
    const IntensityLevels levels = intensity_levels(volume, distance, boundary.blur_mm);
    level = level_function(volume, peak, levels, options);
    boundary.bridges_lps_mm = bridge_pieces(level, tree, options.min_component_mm3);
    keep_tree_only(level, tree, all_above);
    distance = signed_distance(level, kReachMm);
    boundary.blur_mm = blur_across(level, distance);
    distance = undo_blur(distance, boundary.blur_mm, voxel);
    boundary.lumen_intensity = double(levels.lumen_overall);
    boundary.background_intensity = double(levels.background_overall);
    progress.report(0.6 + 0.1 * (iteration + 1), "finding the boundary");
  }
  level = resample_cubic(level, fine_spacing(level.geometry));
  const Volume<std::uint8_t> fine_tree = resample_nearest(tree, level.geometry);
  bridge_pieces(level, fine_tree, options.min_component_mm3);
  keep_tree_only(level, fine_tree, all_above);
  level = undo_blur(signed_distance(level, kReachMm), boundary.blur_mm, voxel);
  keep_tree_only(level, fine_tree, all_above);  // moving it may pinch a thread off
  progress.report(0.95, "finding the boundary");
  boundary.level_set = signed_distance(level, kReachMm);
  return boundary;
}

}  // namespace angio::segmentation::detail

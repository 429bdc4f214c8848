#include "segmentation/detail/bright_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/seeds.hpp"
#include "segmentation/detail/take_out.hpp"
#include "segmentation/detail/tube_axes.hpp"
#include "segmentation/detail/vessel_tree.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr float kCoreExcess = 0.35f;   ///< of the contrast above the lumen: part of an object
constexpr float kObjectExcess = 0.5f;  ///< that an object must reach
constexpr double kTubeShare = 0.5;     ///< of an object's extent with an axis in it: a vessel
constexpr std::size_t kLeastVoxels = 27;

/// Of the tubes of a volume.
struct TubeLevel {
  float lumen = 0.0f;
  float contrast = 0.0f;  ///< 0: there are none
};

TubeLevel tube_level(const std::vector<TubeAxis>& axes, const Volume<float>& denoised) {
  std::vector<std::pair<float, double>> intensity, contrast;
  for (const TubeAxis& axis : axes)
    for (std::size_t n = 0; n < axis.voxels.size(); ++n) {
      const double weight = axis.length_share * double(axis.contrast[n]) * double(axis.contrast[n]);
      intensity.emplace_back(denoised.values[axis.voxels[n]], weight);
      contrast.emplace_back(axis.contrast[n], weight);
    }
  return {weighted_quantile(intensity, 0.9), weighted_quantile(contrast, 0.9)};
}

/// The box of a set of voxels, in steps of the grid.
struct Extent {
  std::array<int, 3> low{1 << 30, 1 << 30, 1 << 30};
  std::array<int, 3> high{-1, -1, -1};
  void add(const std::array<int, 3>& voxel) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], voxel[a]);
      high[a] = std::max(high[a], voxel[a]);
    }
  }
  [[nodiscard]] double length(const Vec3& h) const {
    if (high[0] < 0) return 0.0;
    return std::hypot((high[0] - low[0]) * h.x, (high[1] - low[1]) * h.y, (high[2] - low[2]) * h.z);
  }
};

/// Which pieces of the bright voxels are no vessels.
std::vector<bool> objects_among(const Components& pieces, const Volume<float>& denoised,
                                const std::vector<TubeAxis>& axes, float least_peak,
                                const SegmentationOptions& options) {
  const VolumeGeometry& grid = denoised.geometry;
  std::vector<Extent> extent(pieces.voxel_count.size());
  std::vector<float> peak(extent.size(), -1e30f);
  for (std::size_t v = 0; v < pieces.label.size(); ++v) {
    if (pieces.label[v] == 0) continue;
    const auto p = std::size_t(pieces.label[v]);
    extent[p].add(voxel_of(grid, v));
    peak[p] = std::max(peak[p], denoised.values[v]);
  }
  std::vector<double> tube(extent.size(), 0.0);
  for (const TubeAxis& axis : axes) {
    std::vector<std::pair<std::int32_t, std::size_t>> inside;
    for (std::size_t v : axis.voxels)
      if (pieces.label[v] > 0) inside.emplace_back(pieces.label[v], v);
    std::sort(inside.begin(), inside.end());
    for (std::size_t n = 0; n < inside.size();) {
      const std::int32_t label = inside[n].first;
      Extent part;
      for (; n < inside.size() && inside[n].first == label; ++n)
        part.add(voxel_of(grid, inside[n].second));
      tube[std::size_t(label)] = std::max(tube[std::size_t(label)], part.length(grid.spacing));
    }
  }
  const double voxel = grid.spacing.x * grid.spacing.y * grid.spacing.z;
  std::vector<bool> is_object(extent.size(), false);
  for (std::size_t p = 1; p < extent.size(); ++p)
    is_object[p] = peak[p] >= least_peak && pieces.voxel_count[p] >= kLeastVoxels &&
                   double(pieces.voxel_count[p]) * voxel >= options.min_component_mm3 &&
                   tube[p] < kTubeShare * extent[p].length(grid.spacing);
  for (const Vec3& seed : options.seeds_lps_mm) {
    if (const auto v = voxel_at(grid, seed)) is_object[std::size_t(pieces.label[*v])] = false;
  }
  return is_object;
}

std::string warning_of(const Components& pieces, const std::vector<bool>& is_object, int count,
                       const VolumeGeometry& grid) {
  std::size_t voxels = 0, largest = 0;
  for (std::size_t p = 1; p < is_object.size(); ++p) {
    if (!is_object[p]) continue;
    voxels += pieces.voxel_count[p];
    if (largest == 0 || pieces.voxel_count[p] > pieces.voxel_count[largest]) largest = p;
  }
  Vec3 middle;
  for (std::size_t v = 0; v < pieces.label.size(); ++v)
    if (std::size_t(pieces.label[v]) == largest) {
      const auto voxel = voxel_of(grid, v);
      for (std::size_t a = 0; a < 3; ++a)
        middle[int(a)] += voxel[a] / double(pieces.voxel_count[largest]);
    }
  const Vec3 place = grid.lps_from_index(middle);
  const double volume = double(voxels) * grid.spacing.x * grid.spacing.y * grid.spacing.z;
  return std::to_string(count) + (count == 1 ? " object" : " objects") +
         " brighter than the vessels (bone, calcification or metal), " + format_number(volume) +
         " mm3 in all, the largest around (" + format_number(place.x) + ", " +
         format_number(place.y) + ", " + format_number(place.z) +
         ") mm, were kept out; if that is vessel, set segmentation.exclude_bone = false or give a "
         "seed in it";
}

}  // namespace

BrightObjects find_bright_objects(const Volume<float>& volume, const std::vector<TubeAxis>& axes,
                                  const SegmentationOptions& options) {
  if (axes.empty()) return {};
  const double noise = noise_deviation(volume);
  TubeLevel level = tube_level(axes, volume);
  if (!(double(level.contrast) > 2.0 * noise)) return {};
  const Volume<float> denoised =
      smooth(volume, denoising_sigma(volume, noise, double(level.contrast)));
  level = tube_level(axes, denoised);
  const float least_peak = level.lumen + kObjectExcess * level.contrast;
  if (*std::max_element(denoised.values.begin(), denoised.values.end()) < least_peak) return {};

  BrightObjects objects;
  objects.mask = Volume<std::uint8_t>(volume.geometry);
  for (std::size_t v = 0; v < denoised.values.size(); ++v)
    objects.mask.values[v] = denoised.values[v] > level.lumen + kCoreExcess * level.contrast;
  const Components pieces = label_components(objects.mask, Connectivity::faces);
  const auto is_object = objects_among(pieces, denoised, axes, least_peak, options);
  objects.count = int(std::count(is_object.begin(), is_object.end(), true));
  if (objects.count == 0) return {};
  for (std::size_t v = 0; v < pieces.label.size(); ++v)
    objects.mask.values[v] = is_object[std::size_t(pieces.label[v])];
  objects.warning = warning_of(pieces, is_object, objects.count, volume.geometry);
  add_shells(objects.mask, denoised, float(std::min(noise, 0.05 * double(level.contrast))));
  objects.image_without = take_out(volume, objects.mask, level.lumen - 0.5f * level.contrast);
  return objects;
}

}  // namespace angio::segmentation::detail

#include "segmentation/detail/bright_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "segmentation/detail/blood_level.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/plaque.hpp"
#include "segmentation/detail/seeds.hpp"
#include "segmentation/detail/take_out.hpp"
#include "segmentation/detail/tube_axes.hpp"
#include "segmentation/detail/vessel_tree.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr float kCoreExcess = 0.35f;      ///< of the contrast above the lumen: part of an object
constexpr float kObjectExcess = 0.5f;     ///< that an object must reach
constexpr double kTubeShare = 0.5;        ///< of an object's extent with an axis in it: a vessel
constexpr double kPlaqueQuantile = 0.75;  ///< plaque may lie along a quarter of the vessels
constexpr std::size_t kLeastObjectVoxels = 27;
/// [mm^3]: a millimetre of the least section that counts (1 mm^2: Agatston et al., JACC 15(4),
/// 1990).
constexpr double kLeastPlaque = 1.0;

/// Of the tubes of a volume.
struct TubeLevel {
  float lumen = 0.0f;
  float contrast = 0.0f;  ///< 0: there are none
};

/// @param share  the quantile that is their level
/// @param most   a place counts by its contrast squared, which counts for no more than this
TubeLevel tube_level(const std::vector<TubeAxis>& axes, const Volume<float>& denoised,
                     double share = 0.9, float most = std::numeric_limits<float>::infinity()) {
  std::vector<std::pair<float, double>> intensity, contrast;
  for (const TubeAxis& axis : axes)
    for (std::size_t n = 0; n < axis.voxels.size(); ++n) {
      const double counted = double(std::min(axis.contrast[n], most));
      const double weight = axis.length_share * counted * counted;
      intensity.emplace_back(denoised.values[axis.voxels[n]], weight);
      contrast.emplace_back(axis.contrast[n], weight);
    }
  return {weighted_quantile(intensity, share), weighted_quantile(contrast, share)};
}

/// The median contrast of places on axes, by length.
float typical_contrast(const std::vector<TubeAxis>& axes) {
  std::vector<std::pair<float, double>> contrast;
  for (const TubeAxis& axis : axes)
    for (const float of_place : axis.contrast) contrast.emplace_back(of_place, axis.length_share);
  return weighted_quantile(contrast, 0.5);
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
  [[nodiscard]] VoxelBox box() const {
    return {low, {high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1}};
  }
  [[nodiscard]] double length(const Vec3& h) const {
    if (high[0] < 0) return 0.0;
    return std::hypot((high[0] - low[0]) * h.x, (high[1] - low[1]) * h.y, (high[2] - low[2]) * h.z);
  }
};

std::vector<Extent> extents_of(const Components& pieces, const VolumeGeometry& grid) {
  std::vector<Extent> extents(pieces.voxel_count.size());
  for (std::size_t v = 0; v < pieces.label.size(); ++v)
    if (pieces.label[v] != 0) extents[std::size_t(pieces.label[v])].add(voxel_of(grid, v));
  return extents;
}

/// Which pieces of the bright voxels are large and bright enough to be something.
std::vector<bool> bright_among(const Components& pieces, const Volume<float>& denoised,
                               float least_peak, double least_mm3,
                               const SegmentationOptions& options) {
  const VolumeGeometry& grid = denoised.geometry;
  std::vector<float> peak(pieces.voxel_count.size(), -1e30f);
  for (std::size_t v = 0; v < pieces.label.size(); ++v)
    if (pieces.label[v] != 0) {
      float& of_piece = peak[std::size_t(pieces.label[v])];
      of_piece = std::max(of_piece, denoised.values[v]);
    }
  std::vector<bool> is_bright(peak.size(), false);
  for (std::size_t p = 1; p < peak.size(); ++p)
    is_bright[p] = peak[p] >= least_peak && pieces.voxel_count[p] >= kLeastObjectVoxels &&
                   double(pieces.voxel_count[p]) * voxel_volume(grid) >= least_mm3;
  for (const Vec3& seed : options.seeds_lps_mm)
    if (const auto v = voxel_at(grid, seed)) is_bright[std::size_t(pieces.label[*v])] = false;
  return is_bright;
}

/// Leaves out the pieces that are vessels themselves.
std::vector<bool> without_tubes(std::vector<bool> is_object, const Components& pieces,
                                const std::vector<Extent>& extent,
                                const std::vector<TubeAxis>& axes, const VolumeGeometry& grid) {
  if (is_object.empty()) return {};
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
  for (std::size_t p = 1; p < extent.size(); ++p)
    is_object[p] = is_object[p] && tube[p] < kTubeShare * extent[p].length(grid.spacing);
  return is_object;
}

/// What is brighter than tubes.
struct BrightPieces {
  Components pieces;
  std::vector<Extent> extents;     ///< shape [piece_count + 1]
  std::vector<bool> is_something;  ///< large and bright enough, the same shape
};

BrightPieces find_bright_pieces(const Volume<float>& denoised, const TubeLevel& level,
                                double least_mm3, const SegmentationOptions& options) {
  const float least_peak = level.lumen + kObjectExcess * level.contrast;
  if (*std::max_element(denoised.values.begin(), denoised.values.end()) < least_peak) return {};
  Volume<std::uint8_t> mask(denoised.geometry);
  for (std::size_t v = 0; v < denoised.values.size(); ++v)
    mask.values[v] = denoised.values[v] > level.lumen + kCoreExcess * level.contrast;
  BrightPieces bright{label_components(mask, Connectivity::faces), {}, {}};
  bright.extents = extents_of(bright.pieces, denoised.geometry);
  bright.is_something = bright_among(bright.pieces, denoised, least_peak, least_mm3, options);
  return bright;
}

int count_of(const std::vector<bool>& flags) {
  return int(std::count(flags.begin(), flags.end(), true));
}

/// How much they are, and where the largest is.
std::string amount_of(const Components& pieces, const std::vector<bool>& is_object,
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
  const double volume = double(voxels) * voxel_volume(grid);
  return format_number(volume) + " mm3 in all, the largest around " + format_place(place);
}

}  // namespace

BrightObjects find_bright_objects(const Volume<float>& volume, const std::vector<TubeAxis>& axes,
                                  const BloodLevel& known, const SegmentationOptions& options) {
  if (axes.empty()) return {};
  const double noise = noise_deviation(volume);
  TubeLevel level = tube_level(axes, volume);
  if (!(double(level.contrast) > 2.0 * noise)) return {};
  const Volume<float> denoised =
      smooth(volume, denoising_sigma(volume, noise, double(level.contrast)));
  const VolumeGeometry& grid = volume.geometry;

  level = known.is_told ? TubeLevel{known.lumen, known.contrast()}
                        : tube_level(axes, denoised, kPlaqueQuantile, typical_contrast(axes));
  const PlaqueLevel blood{level.lumen, level.contrast, known.is_told};
  const BrightPieces in_vessels = find_bright_pieces(denoised, level, kLeastPlaque, options);
  std::vector<VoxelBox> boxes;
  for (const Extent& extent : in_vessels.extents) boxes.push_back(extent.box());
  const std::vector<bool> is_plaque =
      find_plaque(in_vessels.pieces, boxes, in_vessels.is_something, axes, denoised, blood);

  level = tube_level(axes, denoised);
  BrightPieces bright = find_bright_pieces(denoised, level, options.min_component_mm3, options);
  for (std::size_t v = 0; v < in_vessels.pieces.label.size(); ++v)
    if (!bright.is_something.empty() && is_plaque[std::size_t(in_vessels.pieces.label[v])])
      bright.is_something[std::size_t(bright.pieces.label[v])] = false;
  const std::vector<bool> is_object =
      without_tubes(std::move(bright.is_something), bright.pieces, bright.extents, axes, grid);

  BrightObjects objects;
  if (const int count = count_of(is_object); count > 0) {
    Volume<std::uint8_t> mask(grid);
    for (std::size_t v = 0; v < bright.pieces.label.size(); ++v)
      mask.values[v] = is_object[std::size_t(bright.pieces.label[v])];
    add_shells(mask, denoised, float(std::min(noise, 0.05 * double(level.contrast))));
    objects.image_without = take_out(volume, mask, level.lumen - 0.5f * level.contrast);
    objects.warnings.push_back(
        std::to_string(count) + (count == 1 ? " object" : " objects") +
        " brighter than the vessels (bone, calcification or metal), " +
        amount_of(bright.pieces, is_object, grid) +
        ", were kept out; if that is vessel, keep bright objects or give a seed in it "
        "(segmentation.exclude_bone = false, segmentation.seeds_lps_mm)");
  }
  if (const int count = count_of(is_plaque); count > 0) {
    if (objects.image_without.values.empty()) objects.image_without = volume;
    darken_plaque(in_vessels.pieces, boxes, is_plaque, denoised, blood, objects.image_without);
    objects.warnings.push_back(
        std::to_string(count) + (count == 1 ? " piece" : " pieces") +
        " of the vessels brighter than blood, " + amount_of(in_vessels.pieces, is_plaque, grid) +
        (count == 1 ? ", is" : ", are") +
        " taken for calcified plaque: the lumen ends half way to its brightness; if that is blood, "
        "keep bright objects or give a seed in it (segmentation.exclude_bone = false, "
        "segmentation.seeds_lps_mm)");
  }
  return objects;
}

}  // namespace angio::segmentation::detail

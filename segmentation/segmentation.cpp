#include "segmentation/segmentation.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/require.hpp"
#include "segmentation/detail/boundary.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/edge_image.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/label_lumen.hpp"
#include "segmentation/detail/label_map.hpp"
#include "segmentation/detail/plausibility.hpp"
#include "segmentation/detail/seeds.hpp"
#include "segmentation/detail/thin_vessels.hpp"
#include "segmentation/detail/vessel_image.hpp"
#include "segmentation/detail/vessel_tree.hpp"
#include "segmentation/detail/wide_parts.hpp"

namespace angio::segmentation {
namespace {

constexpr double kMarginAroundTreeMm =
    5.0;  ///< of background around the tree while its boundary is sought

void check_volume(const Volume<float>& volume) {
  if (volume.values.empty() || volume.values.size() != volume.geometry.voxel_count())
    throw InputError("the volume is empty. Give a volume with voxels");
  for (int axis = 0; axis < 3; ++axis)
    if (volume.geometry.size[std::size_t(axis)] < 3)
      throw InputError(
          "the volume has fewer than 3 voxels along an axis (no vessel can be seen in "
          "it). Give a whole volume");
  if (const auto bad = std::count_if(volume.values.begin(), volume.values.end(),
                                     [](float value) { return !std::isfinite(value); }))
    throw InputError("the volume holds " + std::to_string(bad) +
                     " voxels that are not a number (nothing can be measured beside them). Export "
                     "it again, or replace them by the background's intensity");
  const auto [low, high] = std::minmax_element(volume.values.begin(), volume.values.end());
  if (!(*low < *high))
    throw InputError(
        "every voxel has the same intensity (there is nothing in the volume). Check "
        "the export, or choose another series");
}

Volume<std::uint8_t> mask_of(const Volume<float>& level_set) {
  Volume<std::uint8_t> mask(level_set.geometry);
  const std::size_t slice = mask.values.size() / std::size_t(mask.geometry.size[2]);
  parallel_for(mask.geometry.size[2], [&](std::ptrdiff_t k) {
    for (std::size_t v = std::size_t(k) * slice; v < std::size_t(k + 1) * slice; ++v)
      mask.values[v] = level_set.values[v] < 0.0f;
  });
  return mask;
}

/// The voxels of a region of interest.
Volume<float> part_in_region(const Volume<float>& volume, const LpsBox& region) {
  const VolumeGeometry& grid = volume.geometry;
  Vec3 low{1e30, 1e30, 1e30}, high{-1e30, -1e30, -1e30};
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 index = grid.index_from_lps({corner & 1 ? region.high.x : region.low.x,
                                            corner & 2 ? region.high.y : region.low.y,
                                            corner & 4 ? region.high.z : region.low.z});
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], index[a]);
      high[a] = std::max(high[a], index[a]);
    }
  }
  detail::VoxelBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    const double last = grid.size[a] - 1;
    box.first[a] = int(std::ceil(std::clamp(low[int(a)], 0.0, last)));
    box.size[a] = int(std::floor(std::clamp(high[int(a)], 0.0, last))) - box.first[a] + 1;
    if (box.size[a] < 3)
      throw InputError(
          "segmentation.region_lps_mm holds fewer than 3 voxels along an axis (it lies outside the "
          "volume, or is too thin). Corners are in LPS mm: compare with angio inspect");
  }
  return detail::crop(volume, box);
}

/// One line for each of a few places, or one for all.
std::vector<std::string> narrow_place_warnings(const std::vector<Vec3>& places) {
  constexpr std::size_t kFew = 3;
  std::vector<std::string> warnings;
  if (places.size() <= kFew) {
    for (const Vec3& place : places)
      warnings.push_back("the vessel at " + detail::format_place(place) +
                         " is narrower than the voxels can show (it was kept open, but its "
                         "diameter there is not measured)");
    return warnings;
  }
  std::string some;
  for (std::size_t n = 0; n < kFew; ++n)
    some += (n > 0 ? ", " : "") + detail::format_place(places[n * places.size() / kFew]);
  return {"at " + std::to_string(places.size()) +
          " places the vessels are narrower than the voxels can show (they were kept open, but "
          "their diameters there are not measured), among them at " +
          some};
}

/// Why the blur that was fitted should not be trusted; empty if it can be.
std::string blur_warning(const detail::Boundary& boundary, const Vec3& spacing) {
  constexpr double kClipped = 0.1;  ///< of the lumen
  const std::string effect = " radii of vessels under 3 voxels may be off by some percent";
  if (!boundary.blur_is_told)
    return "the scanner's blur could not be measured in the image (0.6 voxels were assumed;" +
           effect + ")";
  for (int a = 0; a < 3; ++a) {
    const double voxels = boundary.blur_sd_mm[a] / spacing[a];
    if (voxels > 1.03 * detail::kLeastBlurVoxels && voxels < 0.97 * detail::kMostBlurVoxels)
      continue;
    const std::string cause =
        boundary.clipped_share > kClipped
            ? detail::format_number(std::round(100.0 * boundary.clipped_share)) +
                  " % of the lumen's voxels have the highest value of the volume: clipped? Export "
                  "it with its full range"
            : "sharpened, oversmoothed or resampled image?";
    return "the scanner's blur was fitted as " + detail::format_number(voxels) +
           " voxels, the end of its range (" + cause + ");" + effect;
  }
  return {};
}

void refuse_what_is_no_vessel(const Volume<std::uint8_t>& mask, const VolumeGeometry& scanned,
                              bool has_seeds) {
  detail::refuse_flood(mask, scanned);
  detail::refuse_sponge(mask, scanned, has_seeds);
  detail::refuse_shell(mask);
  if (!has_seeds) detail::refuse_crumb(mask, scanned);
}

/// What may be vessel, and those that are.
struct Vessels {
  detail::VesselImage image;
  detail::VesselTree tree;
};

/// Where bone is taken for blood, a seed lies in nothing: what is too bright beside it goes then.
Vessels find_vessels(const Volume<float>& scanned, const SegmentationOptions& options,
                     const Progress& progress) {
  const auto find = [&](std::vector<detail::TubeAxis> axes) {
    Vessels vessels;
    vessels.image =
        detail::find_vessel_image(scanned, std::move(axes), options, part(progress, 0.0, 0.1));
    const Volume<float>& without = vessels.image.without;
    vessels.tree =
        detail::find_vessel_tree(without.values.empty() ? scanned : without, vessels.image.level,
                                 vessels.image.trunks, options, progress);
    return vessels;
  };
  progress.report(0.0, "finding tubes");
  const std::vector<detail::TubeAxis> axes = detail::find_tube_axes(scanned);
  try {
    return find(axes);
  } catch (const detail::SeedInNoVessel&) {
    return find(detail::axes_of_seeds(axes, scanned.geometry, options.seeds_lps_mm));
  }
}

Segmentation segment_all(const Volume<float>& scanned, const SegmentationOptions& options,
                         const Progress& progress) {
  if (const std::vector<Label> labels = detail::find_labels(scanned); !labels.empty())
    return detail::segment_label_map(scanned, labels, options, progress);
  if (!options.labels.empty())
    throw InputError(
        "segmentation.labels is set, but the volume is an image and no label map. Leave it out");
  auto [image, tree] = find_vessels(scanned, options, progress);
  const Volume<float>& volume = image.without.values.empty() ? scanned : image.without;

  const bool has_seeds = !options.seeds_lps_mm.empty();
  if (!has_seeds)  // before minutes go into its boundary
    refuse_what_is_no_vessel(tree.mask, scanned.geometry, has_seeds);

  const detail::VoxelBox box = detail::bounding_box(tree.mask, kMarginAroundTreeMm);
  const Volume<float> around = detail::crop(volume, box);
  const double denoising_mm = detail::denoising_sigma(volume, tree.noise, tree.contrast);
  const Volume<float> denoised = detail::smooth(around, denoising_mm);
  detail::Boundary boundary =
      detail::find_boundary({around, denoised, detail::crop(tree.mask, box), denoising_mm,
                             tree.noise / tree.contrast, tree.seeds_lps_mm.size() > 1, tree.blood},
                            options, progress);

  Segmentation result;
  result.level_set = std::move(boundary.level_set);
  result.mask = mask_of(result.level_set);
  refuse_what_is_no_vessel(result.mask, scanned.geometry, has_seeds);
  result.seeds_lps_mm = std::move(tree.seeds_lps_mm);
  result.lumen_intensity = boundary.lumen_intensity;
  result.background_intensity = boundary.background_intensity;
  result.blur_sd_mm =
      std::cbrt(boundary.blur_sd_mm.x * boundary.blur_sd_mm.y * boundary.blur_sd_mm.z);
  result.warnings = detail::check_plausibility(result.level_set, scanned.geometry);
  if (std::string warning = detail::check_evenness(result.level_set, denoised); !warning.empty())
    result.warnings.push_back(std::move(warning));
  if (std::string warning = detail::check_contrast(result.lumen_intensity, scanned);
      !warning.empty())
    result.warnings.push_back(std::move(warning));
  std::move(tree.warnings.begin(), tree.warnings.end(), std::back_inserter(result.warnings));
  std::move(image.warnings.begin(), image.warnings.end(), std::back_inserter(result.warnings));
  result.narrow_lps_mm = std::move(boundary.bridges_lps_mm);
  for (std::string& warning : narrow_place_warnings(result.narrow_lps_mm))
    result.warnings.push_back(std::move(warning));
  if (std::string warning = blur_warning(boundary, around.geometry.spacing); !warning.empty())
    result.warnings.push_back(std::move(warning));
  if (std::string warning = detail::warn_of_thin_vessels(tree.seen, result.level_set);
      !warning.empty())
    result.warnings.push_back(std::move(warning));
  progress.report(1.0, "vessels segmented");
  return result;
}

}  // namespace

void SegmentationOptions::validate() const {
  require_within("segmentation.smallest_radius_mm", smallest_radius_mm, 0.1, 20.0);
  require_within("segmentation.largest_radius_mm", largest_radius_mm, 0.2, 30.0);
  require_within("segmentation.scale_count", scale_count, 1, 8);
  require_within("segmentation.min_component_mm3", min_component_mm3, 0.0, 1e6);
  if (max_diameter_mm != 0.0)
    require_within("segmentation.max_diameter_mm", max_diameter_mm, 1.0, 60.0);
  if (!(largest_radius_mm >= smallest_radius_mm))
    throw OptionError(
        "segmentation.largest_radius_mm is smaller than "
        "segmentation.smallest_radius_mm (no vessel fits between). Exchange them");
  if (intensity_min && intensity_max && !(*intensity_min < *intensity_max))
    throw OptionError(
        "segmentation.intensity_min is not below segmentation.intensity_max (no "
        "intensity fits between). Exchange them");
  if (region_lps_mm)
    for (int axis = 0; axis < 3; ++axis)
      if (!(region_lps_mm->low[axis] < region_lps_mm->high[axis]))
        throw OptionError(
            "segmentation.region_lps_mm is empty along an axis (its low corner must be below its "
            "high corner). Exchange them");
  for (const double label : labels)
    if (!std::isfinite(label))
      throw OptionError("segmentation.labels holds a value that is not a number");
  for (const Vec3& seed : seeds_lps_mm)
    if (!std::isfinite(seed.x) || !std::isfinite(seed.y) || !std::isfinite(seed.z))
      throw OptionError("segmentation.seeds_lps_mm holds a value that is not a number");
}

Segmentation segment_vessels(const Volume<float>& volume, const SegmentationOptions& options,
                             const Progress& progress) {
  options.validate();
  check_volume(volume);
  Segmentation result =
      options.region_lps_mm
          ? segment_all(part_in_region(volume, *options.region_lps_mm), options, progress)
          : segment_all(volume, options, progress);
  detail::leave_out_wide_parts(options, result);
  return result;
}

bool is_label_map(const Volume<float>& volume) { return !detail::find_labels(volume).empty(); }

}  // namespace angio::segmentation
